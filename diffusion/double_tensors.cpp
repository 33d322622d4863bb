// SPDX-License-Identifier: Apache-2.0
#include "diffusion/double_tensors.hpp"

#include "core/error.hpp"

#include <charconv>
#include <cmath>

namespace elastogen {

void add_doubles(TensorFile& file, const std::string& name, In<double> values) {
  Tensor high{name, {values.rows, values.cols}, {}}, rest{name + ".rest", high.shape, {}};
  for (int64_t k = 0; k < values.size(); ++k) {
    const auto nearest = float(values.data[k]);
    ELASTOGEN_CHECK(std::isfinite(nearest), "number ", k, " of '", name, "' is no float");
    high.values.push_back(nearest);
    rest.values.push_back(float(values.data[k] - double(nearest)));
  }
  file.tensors.push_back(std::move(high));
  file.tensors.push_back(std::move(rest));
}

Array<double> get_doubles(const TensorFile& file, const std::string& name, int64_t rows, int cols) {
  const Tensor& high = file.get(name, {rows, cols});
  const Tensor& rest = file.get(name + ".rest", {rows, cols});
  Array<double> values(rows, cols);
  for (int64_t k = 0; k < values.size(); ++k)
    values.data()[k] = double(high.values[size_t(k)]) + double(rest.values[size_t(k)]);
  return values;
}

int64_t get_count(const TensorFile& file, const std::string& name, int64_t least, int64_t most) {
  const auto found = file.text.find(name);
  ELASTOGEN_CHECK_ASSET(found != file.text.end(), "the file has no text '", name, "'");
  const std::string& text = found->second;
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  ELASTOGEN_CHECK_ASSET(
      error == std::errc() && end == text.data() + text.size() && value >= least && value <= most,
      "'", name, "' must lie in ", least, " ... ", most, ", it is '", text, "'");
  return value;
}

}  // namespace elastogen
