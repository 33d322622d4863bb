// SPDX-License-Identifier: Apache-2.0
#include "io/vtu_file.hpp"

#include "io/frame_files.hpp"
#include "io/safe_file.hpp"

#include <filesystem>
#include <iomanip>

namespace elastogen {
namespace {

/// The name without its folder, as an XML attribute.
std::string escaped(const std::string& path) {
  std::string text;
  for (const char c : std::filesystem::path(path).filename().string()) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else if (c == '"')
      text += "&quot;";
    else
      text += c;
  }
  return text;
}

}  // namespace

void VtuFile::points(const double* x, int64_t points, const Vec3& place) {
  section("<Points>\n");
  std::vector<double> placed(x, x + 3 * points);
  for (size_t k = 0; k < placed.size(); ++k) placed[k] += place[k % 3];
  if (place == Vec3{})
    floats("Points", placed.data(), 3 * points, 3);
  else
    array("Points", "Float64", placed, 3);
  section("</Points>\n");
}

void VtuFile::write(const std::string& path) const {
  SafeFile file(path);
  file.write(xml_ + "<AppendedData encoding=\"raw\">\n_");
  file.write(data_);
  file.write("\n</AppendedData>\n</VTKFile>\n");
  file.commit();
}

PvdFrames::PvdFrames(const std::string& path) : path_(path) {
  SafeFile probe(path);  // throws here if the folder cannot be written
}

void PvdFrames::add(const VtuFile& frame, double time) {
  const std::string name = frame_path(path_, frames_++, ".vtu");
  frame.write(name);
  entries_ += concat("<DataSet timestep=\"", std::setprecision(17), time, "\" part=\"0\" file=\"",
                     escaped(name), "\"/>\n");
}

void PvdFrames::finish() const {
  ELASTOGEN_CHECK(frames_ > 0, path_, ": there is no frame to write");
  write_file(path_,
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
             "byte_order=\"LittleEndian\">\n<Collection>\n" +
                 entries_ + "</Collection>\n</VTKFile>\n");
}

}  // namespace elastogen
