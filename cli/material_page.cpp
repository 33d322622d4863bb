// SPDX-License-Identifier: Apache-2.0
#include "cli/material_page.hpp"

#include "core/error.hpp"
#include "io/html_page.hpp"
#include "io/html_table.hpp"
#include "io/text_format.hpp"
#include "network/law/mtl_weights.hpp"
#include "scene/version.hpp"
#include "training/cells.hpp"
#include "training/fit_report.hpp"
#include "training/net_curve.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace elastogen {
namespace {

constexpr uint64_t kPageSeed = 0x7061'6765;  // differs from the seeds of fits and cards
constexpr int64_t kPageStrains = 20000;

/// An error measured for the page, the same error on the model card, and its limit.
struct ErrorRow {
  const char *name, *key;
  double measured;
  std::optional<double> limit;  ///< none: for information
};

std::vector<ErrorRow> error_rows(const FitReport& r) {
  return {
      {"stress, median", "error.stress.median", r.stress_median, kFitLimits.stress_median},
      {"stress, 99 of 100 strains", "error.stress.p99", r.stress_p99, kFitLimits.stress_p99},
      {"stress, all strains", "error.stress.max", r.stress_max, kFitLimits.stress_max},
      {"tangent, 99 of 100 strains", "error.tangent.p99", r.tangent_p99, kFitLimits.tangent_p99},
      {"energy, all strains", "error.energy.max", r.energy_max, {}}};
}

/// A number of the model card, if it has one there.
std::optional<double> card_number(const TensorFile& file, const std::string& key) {
  const auto found = file.text.find(key);
  if (found == file.text.end()) return std::nullopt;
  try {
    return number(found->second);
  } catch (const Error&) {  // without the number the limit is missed
    return std::nullopt;
  }
}

/// Whether both the card's number and the measured one keep the limit.
bool passes(const ErrorRow& row, const TensorFile& file) {
  if (!row.limit) return true;
  const std::optional<double> card = card_number(file, row.key);
  return card && *card <= *row.limit && row.measured <= *row.limit;
}

std::string percent(double share) {
  return number_cell(100 * share) + " %";
}

std::string error_table(const std::vector<ErrorRow>& rows, const TensorFile& file) {
  HtmlTable table;
  table.heads = {"relative error", "of the card", "measured for this page", "limit", ""};
  for (const ErrorRow& row : rows) {
    const std::optional<double> card = card_number(file, row.key);
    const std::string verdict = passes(row, file) ? "passes" : "MISSES";
    table.rows.push_back({row.name, card ? percent(*card) : kNoCell, percent(row.measured),
                          row.limit ? percent(*row.limit) : kNoCell,
                          row.limit ? verdict : kNoCell});
  }
  return html_table(table);
}

std::string card_table(const MaterialPage& page) {
  HtmlTable table;
  table.heads = {"key", "value"};
  table.rows = {{"file", page.place}, {"SHA-256 of the file", page.hash}};
  for (const auto& [key, value] : page.weights.text) table.rows.push_back({key, value});
  return html_table(table);
}

std::string mode_title(LoadPath path) {
  switch (path) {
    case LoadPath::kUniaxial:
      return "Uniaxial load, stretches (l, b, b)";
    case LoadPath::kBiaxial:
      return "Equibiaxial load, stretches (l, l, b)";
    case LoadPath::kShear:
      return "Pure shear (planar load), stretches (l, 1, b)";
    case LoadPath::kVolume:
      break;
  }
  return "Change of volume, stretches (l, l, l)";
}

/// Plots of law and net in one frame, and below them the errors of the net.
std::string curve_figures(const NetCurve& curve) {
  const PlotAxis stretch{"stretch l [-]", false};
  const std::string title = mode_title(curve.path);
  const LinePlot stress{
      title + ": stress",
      stretch,
      {"nominal stress [E]", false},
      {{"law", curve.stretch, curve.law_stress, {}}, {"net", curve.stretch, curve.net_stress, {}}}};
  const LinePlot energy{
      title + ": energy",
      stretch,
      {"energy density [E]", false},
      {{"law", curve.stretch, curve.law_energy, {}}, {"net", curve.stretch, curve.net_energy, {}}}};
  LinePlot errors{title + ": errors", stretch, {"relative error [-]", true}, {}};
  errors.series = {{"stress", {}, {}, {}}, {"tangent", {}, {}, {}}, {"energy", {}, {}, {}}};
  const std::vector<double>* values[] = {&curve.stress_error, &curve.tangent_error,
                                         &curve.energy_error};
  // leave out the rest state, where all errors are 0
  for (size_t k = 0; k < curve.stretch.size(); ++k)
    for (size_t n = 0; n < 3 && curve.stretch[k] != 1; ++n) {
      errors.series[n].x.push_back(curve.stretch[k]);
      errors.series[n].y.push_back((*values[n])[k]);
    }
  const double limit = kFitLimits.stress_max;
  errors.series.push_back({"limit of stress, " + percent(limit),
                           {curve.stretch.front(), curve.stretch.back()},
                           {limit, limit},
                           {}});
  return concat("<h3>", markup_text(title), "</h3>\n",
                html_figure(line_plot(stress), "Force along the first axis over the area at rest."),
                html_figure(line_plot(energy), "Over the volume at rest."),
                html_figure(line_plot(errors),
                            "All three stresses, tangents and energies of the states of the law; "
                            "relative as in the table of errors."));
}

/// Histogram of the strains over the decadic logarithm of their error, drawn as its outline. The
/// first bin has all smaller errors.
std::string histogram(const std::string& title, const std::vector<double>& errors,
                      const std::vector<std::pair<std::string, double>>& limits) {
  // share of the strains in each bin
  constexpr int kLowest = -9, kHighest = 1, kPerDecade = 8,
                kBins = (kHighest - kLowest) * kPerDecade;
  std::vector<double> shares(kBins);
  for (const double error : errors) {
    const double place = (std::log10(error) - kLowest) * kPerDecade;
    const int bin = place > 0 ? int(std::min(place, double(kBins - 1))) : 0;
    shares[size_t(bin)] += 100.0 / double(errors.size());
  }
  // outline up to the last bin that is not empty
  int last = kBins - 1;
  while (last > 0 && shares[size_t(last)] == 0) --last;
  PlotSeries outline{"strains", {}, {}, {}};
  for (int bin = 0; bin <= last; ++bin)
    for (int side = 0; side < 2; ++side) {
      outline.x.push_back(std::pow(10, kLowest + double(bin + side) / kPerDecade));
      outline.y.push_back(shares[size_t(bin)]);
    }
  // limits as vertical lines
  const double most = *std::max_element(shares.begin(), shares.end());
  LinePlot plot{title, {"relative error [-]", true}, {"strains in a bin [%]", false}, {outline}};
  for (const auto& [name, limit] : limits)
    plot.series.push_back({name, {limit, limit}, {0, most}, {}});
  return html_figure(line_plot(plot), concat("Eight bins a decade over ", errors.size(),
                                             " strains; what is below 1e-9 is in the first."));
}

std::string introduction(const MaterialPage& page, bool passing) {
  return concat("<h1>The net of ", markup_text(page.subject), "</h1>\n<p>",
                markup_text(page.material.name), ": law ",
                markup_text(law_text(page.material.terms)), ", Poisson ratio ",
                short_number(page.material.poisson, 6), ". The net ",
                passing ? "passes" : "<strong>misses</strong>",
                " its limits. Energies and stresses are over Young's modulus E, which is a factor. "
                "The box of "
                "strains has log stretches within \xc2\xb1",
                short_number(kDeclaredBox.stretch, 3), " and volumes halved to doubled.</p>\n");
}

std::string curves(const MaterialPage& page) {
  std::string figures =
      "<p>Free sides carry no traction by the law; the net is looked at in the same states. A load "
      "ends where its states leave the box.</p>\n";
  for (const LoadPath path :
       {LoadPath::kUniaxial, LoadPath::kBiaxial, LoadPath::kShear, LoadPath::kVolume})
    figures += curve_figures(
        net_curve(page.material, page.weights.get("neural_mtl", {kMtlParameters}).values, path));
  return figures;
}

std::string histograms(const StrainErrors& errors) {
  return histogram("Errors of the stress", errors.stress,
                   {{"median, " + percent(kFitLimits.stress_median), kFitLimits.stress_median},
                    {"99 of 100, " + percent(kFitLimits.stress_p99), kFitLimits.stress_p99},
                    {"all, " + percent(kFitLimits.stress_max), kFitLimits.stress_max}}) +
         histogram("Errors of the tangent", errors.tangent,
                   {{"99 of 100, " + percent(kFitLimits.tangent_p99), kFitLimits.tangent_p99}});
}

}  // namespace

PageResult material_page(const MaterialPage& page) {
  const std::vector<float>& weights = page.weights.get("neural_mtl", {kMtlParameters}).values;
  const StrainErrors errors =
      strain_errors(page.material, weights,
                    sample_strains(declared_box(page.material), kPageSeed, 0, kPageStrains));
  const std::vector<ErrorRow> rows = error_rows(report_of(errors));
  PageResult result;
  result.passes = std::all_of(rows.begin(), rows.end(),
                              [&](const ErrorRow& row) { return passes(row, page.weights); });
  const std::string foot = concat("<footer>\n<h2>Command</h2>\n<p>", markup_text(version_text()),
                                  "</p>\n<pre>", markup_text(page.command), "</pre>\n</footer>\n");
  result.html = html_page(
      "The net of " + page.subject,
      concat(introduction(page, result.passes),
             html_section("Errors", error_table(rows, page.weights)),
             html_section("Weights", card_table(page)), html_section("Loads", curves(page)),
             html_section("Errors on strains that no fit has seen", histograms(errors)), foot));
  return result;
}

}  // namespace elastogen
