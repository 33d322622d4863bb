// SPDX-License-Identifier: Apache-2.0
// Gmsh's MSH format (Gmsh reference manual, "MSH file format" and "Node ordering").

#include "io/tets/mesh_source.hpp"
#include "io/tets/tet_soup.hpp"

#include <algorithm>

namespace elastogen::tets {
namespace {

constexpr Number kInt = Number::kInt32, kSize = Number::kUint64, kDouble = Number::kFloat64;

/// Nodes of an element by Gmsh's number of its type; 0 for elements that are neither tetrahedra nor
/// left out.
int nodes_of_type(int64_t type) {
  switch (type) {
    // tetrahedra, linear and quadratic
    case 4:
      return 4;
    case 11:
      return 10;
    // elements that are left out
    case 15:  // point
      return 1;
    case 1:  // lines
      return 2;
    case 8:
      return 3;
    case 26:
      return 4;
    case 2:  // triangles
      return 3;
    case 9:
      return 6;
    case 21:
      return 10;
    case 3:  // quadrangles
      return 4;
    case 16:
      return 8;
    case 10:
      return 9;
    default:
      return 0;
  }
}

const char* name_of_type(int64_t type) {
  switch (type) {
    case 5:
    case 12:
    case 17:
      return "a hexahedron";
    case 6:
    case 13:
    case 18:
      return "a prism";
    case 7:
    case 14:
    case 19:
      return "a pyramid";
    case 29:
    case 30:
    case 31:
      return "a tetrahedron of higher order";
    default:
      return "unknown";
  }
}

/// Values by their number in a file (of a node or an entity), in ascending order.
template <class T>
class Numbering {
 public:
  void add(int64_t number, T value) { entries_.push_back({number, value}); }
  /// Sorts. @return a number that is there twice, if there is one.
  std::optional<int64_t> finish() {
    std::sort(entries_.begin(), entries_.end());
    for (size_t k = 1; k < entries_.size(); ++k)
      if (entries_[k - 1].first == entries_[k].first) return entries_[k].first;
    return {};
  }
  std::optional<T> find(int64_t number) const {
    const auto at = std::lower_bound(entries_.begin(), entries_.end(), number,
                                     [](const auto& entry, int64_t n) { return entry.first < n; });
    if (at == entries_.end() || at->first != number) return {};
    return at->second;
  }

 private:
  std::vector<std::pair<int64_t, T>> entries_;
};

class MshParser {
 public:
  MshParser(std::string_view bytes, const std::string& path) : source_(bytes, path), path_(path) {}

  TetSoup parse() {
    for (std::string_view word; !(word = source_.next_word()).empty();) {
      source_.check(word.starts_with('$'), "a section should begin, not \"", word.substr(0, 40),
                    '"');
      const std::string name(word.substr(1));
      if (!read_section(name)) {
        source_.skip_past("$End" + name);
        source_.line();
      }
    }
    source_.check(has_elements_, "the file ends without $Elements");
    return std::move(soup_);
  }

 private:
  /// @return false if sections of this name are not read.
  bool read_section(const std::string& name) {
    // sections come in an order: version, then nodes, then elements
    if (name == "MeshFormat") {
      source_.check(version_ == 0, "a second $MeshFormat");
      read_format();
    } else if (name == "Entities" && version_ == 4) {
      begin_data();
      read_entities();
    } else if (name == "Nodes") {
      source_.check(version_ > 0 && !has_nodes_, "a second $Nodes, or one before $MeshFormat");
      version_ == 2 ? read_nodes_2() : read_nodes_4();
      has_nodes_ = true;
      const std::optional<int64_t> twice = node_.finish();
      source_.check(!twice, "the node ", twice.value_or(0), " is there twice");
    } else if (name == "Elements") {
      source_.check(has_nodes_ && !has_elements_,
                    "a second $Elements, or one before $Nodes ($ParametricNodes are not read)");
      version_ == 2 ? read_elements_2() : read_elements_4();
      has_elements_ = true;
    } else {
      return false;
    }
    // every section ends with its name
    source_.begin_text();
    const std::string_view end = source_.word("the end of a section");
    source_.check(end == "$End" + name, "$End", name, " is expected, not \"", end.substr(0, 40),
                  '"');
    return true;
  }

  void read_format() {
    const std::string_view version = source_.word("the version");
    version_ = version == "4.1" ? 4 : version == "2" || version.starts_with("2.") ? 2 : 0;
    source_.check(version_ > 0, "version \"", version.substr(0, 40),
                  "\" is not read; save it as 4.1 or 2.2");
    is_binary_ = source_.integer_below(kInt, 2, "the kind of file") == 1;
    const int64_t size = source_.integer(kInt, "the size of a number");
    source_.check(!is_binary_ || size == 8, "numbers of 8 bytes are expected, not of ", size);
    begin_data();
    if (!is_binary_) return;
    const int64_t one = source_.integer(kInt, "the number 1");
    if (one == 1) return;
    source_.check(one == 1 << 24, "the number 1 is expected, which tells the order of bytes");
    order_ = other_order();
  }

  /// Switches to binary data behind the end of this line, if the file is binary.
  void begin_data() {
    if (!is_binary_) return;
    source_.line();
    source_.begin_binary(order_);
  }

  /// Keeps the first physical group of each volume.
  void read_entities() {
    int64_t count[4];
    for (int64_t& n : count) n = source_.integer(kSize, "the number of entities");
    for (int dimension = 0; dimension < 4; ++dimension) {
      source_.claim(count[dimension], kInt, "entities");
      for (int64_t k = 0; k < count[dimension]; ++k) read_entity(dimension);
    }
    physical_.finish();
  }

  void read_entity(int dimension) {
    const int64_t tag = source_.integer(kInt, "an entity");
    source_.skip(dimension == 0 ? 3 : 6, kDouble, "the box of an entity");
    const int64_t groups = source_.integer(kSize, "the number of physical groups");
    source_.claim(groups, kInt, "physical groups");
    for (int64_t g = 0; g < groups; ++g) {
      const int64_t group = source_.integer(kInt, "a physical group");
      if (g == 0 && dimension == 3) physical_.add(tag, group);
    }
    if (dimension > 0)
      source_.skip(source_.integer(kSize, "the number of borders"), kInt, "borders of an entity");
  }

  void add_node(int64_t number) {
    node_.add(number, int32_t(soup_.points.size()));
    Vec3 x;
    for (double& value : x) value = source_.finite(kDouble, "a coordinate of a node");
    soup_.points.push_back(x);
  }

  void read_nodes_2() {
    const int64_t count = source_.integer(kSize, "the number of nodes");
    begin_data();
    source_.claim(count, kInt, "nodes");
    for (int64_t k = 0; k < count; ++k) add_node(source_.integer(kInt, "the number of a node"));
  }

  void read_nodes_4() {
    begin_data();
    const int64_t blocks = source_.integer(kSize, "the number of blocks");
    source_.skip(3, kSize, "the range of nodes");
    std::vector<int64_t> numbers;
    for (int64_t b = 0; b < blocks; ++b) {
      const int64_t dimension = source_.integer_below(kInt, 4, "the dimension of a block");
      source_.integer(kInt, "the entity of a block");
      const bool parametric = source_.integer_below(kInt, 2, "whether a block has parameters") == 1;
      const int64_t count = source_.integer(kSize, "the number of nodes");
      source_.claim(count, kSize, "nodes");
      numbers.clear();
      for (int64_t k = 0; k < count; ++k)
        numbers.push_back(source_.integer(kSize, "the number of a node"));
      for (const int64_t number : numbers) {
        add_node(number);
        if (parametric) source_.skip(dimension, kDouble, "parameters of a node");
      }
    }
  }

  void read_elements_2() {
    const int64_t count = source_.integer(kSize, "the number of elements");
    begin_data();
    source_.claim(count, kInt, "elements");
    for (int64_t done = 0; done < count;) {
      // in text each element is a block of its own, which begins with its number
      if (!is_binary_) source_.integer(kInt, "the number of an element");
      const int64_t type = read_type();
      const int64_t block =
          is_binary_ ? source_.integer_below(kInt, count - done + 1, "the size of a block") : 1;
      const int64_t tags = source_.integer(kInt, "the number of tags");
      for (int64_t k = 0; k < block; ++k) {
        if (is_binary_) source_.integer(kInt, "the number of an element");
        read_element(type, read_tags(tags), kInt);
      }
      done += block;
    }
  }

  /// The physical group if there is one, else the entity.
  int64_t read_tags(int64_t tags) {
    source_.claim(tags, kInt, "tags");
    int64_t region = 0;
    for (int64_t t = 0; t < tags; ++t) {
      const int64_t tag = source_.integer(kInt, "a tag");
      if (t == 0 || (t == 1 && region == 0)) region = tag;
    }
    return region;
  }

  void read_elements_4() {
    begin_data();
    const int64_t blocks = source_.integer(kSize, "the number of blocks");
    source_.skip(3, kSize, "the range of elements");
    for (int64_t b = 0; b < blocks; ++b) {
      source_.integer_below(kInt, 4, "the dimension of a block");
      const int64_t entity = source_.integer(kInt, "the entity of a block");
      const int64_t type = read_type();
      const int64_t count = source_.integer(kSize, "the number of elements");
      source_.claim(count, kSize, "elements");
      for (int64_t k = 0; k < count; ++k) {
        source_.integer(kSize, "the number of an element");
        read_element(type, physical_.find(entity).value_or(entity), kSize);
      }
    }
  }

  int64_t read_type() {
    const int64_t type = source_.integer(kInt, "the type of an element");
    source_.check(nodes_of_type(type) > 0, "elements of type ", type, " (", name_of_type(type),
                  ") are not read; only tetrahedra of 4 and 10 nodes are");
    return type;
  }

  void read_element(int64_t type, int64_t region, Number number) {
    const int nodes = nodes_of_type(type);
    const bool is_tet = type == 4 || type == 11;
    if (!is_tet) ++soup_.skipped;
    if (!is_tet && type != 2) return source_.skip(nodes, number, "nodes of an element");
    if (is_tet)
      soup_.begin_tet(nodes, region, path_);
    else
      soup_.triangle_region.push_back(region);
    for (int k = 0; k < nodes; ++k) {
      const int64_t n = source_.integer(number, "a node of an element");
      const std::optional<int32_t> point = node_.find(n);
      source_.check(point.has_value(), "a ", is_tet ? "tetrahedron" : "triangle", " has the node ",
                    n, ", which is not there");
      (is_tet ? soup_.corners : soup_.triangles).push_back(*point);
    }
    // Gmsh puts the middle of 23 before that of 13
    if (nodes == 10) std::swap(soup_.corners.end()[-1], soup_.corners.end()[-2]);
  }

  MeshSource source_;
  const std::string& path_;
  TetSoup soup_;
  Numbering<int32_t> node_;      ///< points by their numbers in the file
  Numbering<int64_t> physical_;  ///< physical groups of volumes
  int version_ = 0;              ///< 2 or 4, 0 before it is known
  bool is_binary_ = false, has_nodes_ = false, has_elements_ = false;
  std::endian order_ = std::endian::native;
};

}  // namespace

TetSoup parse_msh(std::string_view bytes, const std::string& path) {
  return MshParser(bytes, path).parse();
}

}  // namespace elastogen::tets
