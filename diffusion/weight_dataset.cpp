// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_dataset.hpp"

#include "core/error.hpp"
#include "diffusion/hidden_hash.hpp"
#include "diffusion/material_features.hpp"
#include "io/hdf5_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace elastogen {
namespace {

using hdf5::Handle;

constexpr std::string_view kSeal = "elastogen-weight-dataset 1\n";  // then the hash of the rest
constexpr size_t kUserBlock = 512, kHashDigits = 64;
constexpr hsize_t kMostRows = 1 << 20;
constexpr size_t kLongestText = 1024;

/// A file in memory. @param image  bytes to open; empty: a new file with a user block.
Handle memory_file(std::string_view image, const std::string& place) {
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are thrown, not printed
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, place);
  hdf5::check(H5Pset_fapl_core(access, 1 << 20, 0), place);
  if (image.empty()) {
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, place);
    hdf5::check(H5Pset_userblock(creation, kUserBlock), place);
    return {H5Fcreate("memory", H5F_ACC_TRUNC, creation, access), H5Fclose, place};
  }
  hdf5::check(H5Pset_file_image(access, const_cast<char*>(image.data()), image.size()), place);
  const hid_t file = H5Fopen("memory", H5F_ACC_RDONLY, access);
  ELASTOGEN_CHECK_ASSET(file >= 0, place, ": not an HDF5 file");
  return {file, H5Fclose, place};
}

/// A text type of a length.
Handle text_type(size_t length) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "text");
  hdf5::check(H5Tset_size(type, length), "text");
  return type;
}

/// Writes texts, all in the length of the longest.
void write_texts(hid_t file, const char* name, std::vector<std::string> texts) {
  size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size() + 1);
  std::string block;
  for (std::string& text : texts) text.resize(length), block += text;
  const Handle type = text_type(length);
  const Handle array = hdf5::create_dataset(file, name, type, {hsize_t(texts.size())});
  hdf5::check(H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), name);
}

template <class T>
void write_numbers(hid_t file, const char* name, const std::vector<T>& values) {
  hdf5::write_dataset<T>(file, name, {values.data(), int64_t(values.size()), 1});
}

std::string image_of(hid_t file) {
  hdf5::check(H5Fflush(file, H5F_SCOPE_GLOBAL), "dataset");
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  hdf5::check(size > 0 ? 0 : -1, "dataset");
  std::string image(kUserBlock + size_t(size), '\0');  // the library does not write the user block
  const ssize_t got = H5Fget_file_image(file, image.data() + kUserBlock, size_t(size));
  hdf5::check(got == size ? 0 : -1, "dataset");
  return image;
}

/// Reads arrays of a file, each after checks.
class Arrays {
 public:
  Arrays(hid_t file, size_t bytes, const std::string& place)
      : file_(file), bytes_(bytes), place_(place) {}

  hsize_t rows(const char* name) const {
    const Handle array = open(name);
    const std::vector<hsize_t> extents = extents_of(array, name);
    ELASTOGEN_CHECK_ASSET(extents.size() == 1 && extents[0] > 0 && extents[0] <= kMostRows, place_,
                          ": '", name, "' must have 1 to ", kMostRows, " rows and one dimension");
    return extents[0];
  }

  /// Reads numbers of an array (rows, cols), or (rows) if cols is 1.
  template <class T>
  std::vector<T> numbers(const char* name, hsize_t rows, hsize_t cols) const {
    const Handle array = open(name);
    std::vector<hsize_t> extents = {rows};
    if (cols != 1) extents.push_back(cols);
    const auto types = hdf5::number_type<T>();
    check_kind(array, name, types.file);
    check_memory(array, name, extents, sizeof(T));
    std::vector<T> values(rows * cols);
    read(array, name, types.memory, values.data());
    if constexpr (std::is_floating_point_v<T>)
      for (size_t k = 0; k < values.size(); ++k)
        ELASTOGEN_CHECK_ASSET(std::isfinite(values[k]), place_, ": number ", k, " of '", name,
                              "' is not finite");
    return values;
  }

  std::vector<std::string> texts(const char* name, hsize_t rows) const {
    const Handle array = open(name);
    const Handle type(H5Dget_type(array), H5Tclose, name);
    const size_t length = H5Tget_size(type);
    ELASTOGEN_CHECK_ASSET(H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
                              length > 0 && length <= kLongestText,
                          place_, ": '", name, "' must have texts of one length up to ",
                          kLongestText);
    check_memory(array, name, {rows}, length);
    std::string block(rows * length, '\0');
    read(array, name, text_type(length), block.data());
    std::vector<std::string> texts;
    for (size_t n = 0; n < rows; ++n) {
      const char* const begin = block.data() + n * length;
      texts.emplace_back(begin, strnlen(begin, length));
    }
    return texts;
  }

 private:
  Handle open(const char* name) const {
    H5L_info_t link;
    ELASTOGEN_CHECK_ASSET(
        H5Lget_info(file_, name, &link, H5P_DEFAULT) >= 0 && link.type == H5L_TYPE_HARD, place_,
        ": there is no array '", name, "'");
    const hid_t array = H5Dopen2(file_, name, H5P_DEFAULT);
    ELASTOGEN_CHECK_ASSET(array >= 0, place_, ": '", name, "' is no array");
    return {array, H5Dclose, name};
  }

  std::vector<hsize_t> extents_of(hid_t array, const char* name) const {
    const Handle space(H5Dget_space(array), H5Sclose, name);
    const int rank = H5Sget_simple_extent_ndims(space);
    ELASTOGEN_CHECK_ASSET(rank >= 0 && rank <= 2, place_, ": '", name, "' has ", rank,
                          " dimensions");
    std::vector<hsize_t> extents(size_t(rank), 0);
    H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    return extents;
  }

  void check_kind(hid_t array, const char* name, hid_t expected) const {
    const Handle type(H5Dget_type(array), H5Tclose, name);
    ELASTOGEN_CHECK_ASSET(H5Tequal(type, expected) > 0, place_, ": '", name,
                          "' is of another type of number");
  }

  /// Checks the extents of an array, and that its numbers lie in this file as plain numbers.
  void check_memory(hid_t array, const char* name, const std::vector<hsize_t>& extents,
                    size_t size) const {
    ELASTOGEN_CHECK_ASSET(extents_of(array, name) == extents, place_, ": '", name,
                          "' does not have ", extents[0], " rows",
                          extents.size() > 1 ? concat(" of ", extents[1]) : "");
    for (const hsize_t extent : extents) size *= extent;
    const Handle creation(H5Dget_create_plist(array), H5Pclose, name);
    const H5D_layout_t layout = H5Pget_layout(creation);
    const bool plain =
        (layout == H5D_CONTIGUOUS || layout == H5D_COMPACT) && H5Pget_external_count(creation) == 0;
    ELASTOGEN_CHECK_ASSET(plain && size <= bytes_ && H5Dget_storage_size(array) == size, place_,
                          ": '", name, "' does not lie in the file as plain numbers");
  }

  void read(hid_t array, const char* name, hid_t type, void* to) const {
    ELASTOGEN_CHECK_ASSET(H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, to) >= 0, place_,
                          ": '", name, "' cannot be read");
  }

  hid_t file_;
  size_t bytes_;
  const std::string& place_;
};

void check_seal(std::string_view bytes, const std::string& place) {
  ELASTOGEN_CHECK_ASSET(bytes.substr(0, kSeal.size()) == kSeal, place,
                        ": not a dataset of weights (it does not begin with '",
                        kSeal.substr(0, kSeal.size() - 1), "')");
  ELASTOGEN_CHECK_ASSET(bytes.size() > kUserBlock && bytes.substr(kSeal.size(), kHashDigits) ==
                                                         hex(sha256(bytes.substr(kUserBlock))),
                        place, ": cut short or changed since it was written; make it anew");
}

FitMaterial material_of(const std::string& law, double poisson, size_t n,
                        const std::string& place) {
  try {
    return fit_material(law, poisson);
  } catch (const Error& error) {
    throw Error(concat(place, ": material ", n, ": ", error.what()), ErrorKind::kAsset);
  }
}

template <class T>
Array<T> array_of(const std::vector<T>& values, int cols) {
  Array<T> array(int64_t(values.size()) / cols, cols);
  std::copy(values.begin(), values.end(), array.data());
  return array;
}

/// Checks the values, after types and sizes.
void check_content(const WeightDataset& data, const std::vector<double>& features,
                   const std::string& place) {
  for (size_t k = 0; k < features.size(); ++k)
    ELASTOGEN_CHECK_ASSET(std::abs(features[k] - data.features.data()[k]) <= 1e-9, place,
                          ": the features of material ", int64_t(k) / kMaterialFeatures,
                          " are not those of its law");
  for (size_t n = 0; n < data.rms.size(); ++n)
    ELASTOGEN_CHECK_ASSET(data.rms[n] >= 0 && data.iterations[n] >= 0, place, ": material ", n,
                          " has a negative error or number of iterations");
}

}  // namespace

std::vector<float> WeightDataset::weights(int64_t n) const {
  std::vector<float> w = hidden;
  std::copy_n(layers.row(n), kMtlWidthOfLast, w.end() - kMtlLast);
  return w;
}

bool WeightDataset::passes(int64_t n) const {
  FitReport report;
  report.stress_median = errors(n, 0), report.stress_p99 = errors(n, 1);
  report.stress_max = errors(n, 2), report.tangent_p99 = errors(n, 3);
  return report.passes();
}

WeightDataset empty_dataset(std::vector<float> hidden, std::vector<FitMaterial> materials) {
  hidden_hash(hidden);  // checks the number of weights
  WeightDataset data;
  data.hidden = std::move(hidden);
  std::fill(data.hidden.end() - kMtlLast, data.hidden.end(), 0.0f);
  data.materials = std::move(materials);
  const int64_t n = data.count();
  data.features = Array<double>(n, kMaterialFeatures);
  for (int64_t k = 0; k < n; ++k) {
    const std::vector<double> x = material_features(data.materials[size_t(k)]);
    std::copy(x.begin(), x.end(), data.features.row(k));
  }
  data.layers = Array<float>(n, kMtlWidthOfLast);
  data.errors = Array<double>(n, 4);
  data.rms.resize(size_t(n));
  data.iterations.resize(size_t(n));
  return data;
}

WeightDataset dataset_rows(const WeightDataset& data, const std::vector<int64_t>& numbers) {
  std::vector<FitMaterial> materials;
  for (const int64_t n : numbers) materials.push_back(data.materials[size_t(n)]);
  WeightDataset rows = empty_dataset(data.hidden, std::move(materials));
  for (size_t k = 0; k < numbers.size(); ++k) {
    const int64_t n = numbers[k];
    std::copy_n(data.layers.row(n), data.layers.cols(), rows.layers.row(int64_t(k)));
    std::copy_n(data.errors.row(n), data.errors.cols(), rows.errors.row(int64_t(k)));
    rows.rms[k] = data.rms[size_t(n)], rows.iterations[k] = data.iterations[size_t(n)];
  }
  return rows;
}

std::string encode_dataset(const WeightDataset& data) {
  const int64_t n = data.count();
  // all arrays must have a row for each material
  ELASTOGEN_CHECK(n > 0 && n <= int64_t(kMostRows), "a dataset has 1 to ", kMostRows,
                  " materials, not ", n);
  const auto is = [&](const auto& array, int cols) {
    return array.rows() == n && array.cols() == cols;
  };
  ELASTOGEN_CHECK(is(data.features, kMaterialFeatures) && is(data.layers, kMtlWidthOfLast) &&
                      is(data.errors, 4) && int64_t(data.rms.size()) == n &&
                      int64_t(data.iterations.size()) == n,
                  "arrays of the dataset do not have ", n, " rows");
  // write the arrays to a file in memory
  const Handle file = memory_file({}, "dataset");
  std::vector<std::string> laws;
  std::vector<double> poisson;
  for (const FitMaterial& material : data.materials) {
    laws.push_back(law_text(material.terms));
    poisson.push_back(material.poisson);
  }
  write_texts(file, "law", laws);
  write_texts(file, "hidden_sha256", {hidden_hash(data.hidden)});
  write_numbers(file, "poisson", poisson);
  write_numbers(file, "hidden", data.hidden);
  hdf5::write_dataset<double>(file, "features", data.features);
  hdf5::write_dataset<float>(file, "layers", data.layers);
  hdf5::write_dataset<double>(file, "errors", data.errors);
  write_numbers(file, "rms", data.rms);
  write_numbers(file, "iterations", data.iterations);
  // seal it with its hash in the user block
  std::string bytes = image_of(file);
  const std::string seal =
      std::string(kSeal) + hex(sha256(std::string_view(bytes).substr(kUserBlock))) + '\n';
  std::copy(seal.begin(), seal.end(), bytes.begin());
  return bytes;
}

WeightDataset decode_dataset(std::string_view bytes, const std::string& place) {
  check_seal(bytes, place);
  const Handle file = memory_file(bytes, place);
  const Arrays arrays(file, bytes.size(), place);
  const hsize_t n = arrays.rows("poisson");
  const std::vector<double> poisson = arrays.numbers<double>("poisson", n, 1);
  const std::vector<std::string> laws = arrays.texts("law", n);
  std::vector<FitMaterial> materials;
  for (size_t k = 0; k < n; ++k) materials.push_back(material_of(laws[k], poisson[k], k, place));
  WeightDataset data =
      empty_dataset(arrays.numbers<float>("hidden", kMtlParameters, 1), std::move(materials));
  ELASTOGEN_CHECK_ASSET(arrays.texts("hidden_sha256", 1)[0] == hidden_hash(data.hidden), place,
                        ": the hash of its hidden layers is another than it states");
  data.layers = array_of(arrays.numbers<float>("layers", n, kMtlWidthOfLast), kMtlWidthOfLast);
  data.errors = array_of(arrays.numbers<double>("errors", n, 4), 4);
  data.rms = arrays.numbers<double>("rms", n, 1);
  data.iterations = arrays.numbers<int32_t>("iterations", n, 1);
  check_content(data, arrays.numbers<double>("features", n, kMaterialFeatures), place);
  return data;
}

}  // namespace elastogen
