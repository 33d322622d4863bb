// SPDX-License-Identifier: Apache-2.0
// elastogen-reader FORMAT PATH (vdb:GRID PATH for a grid by its name): reads one file in a limited
// process and writes the asset, or the reason why there is none, to standard output
// (io/asset_stream.hpp). io/child_reader.hpp starts it.
// elastogen-reader image EDGE: decodes the image on its standard input (io/decode_image.hpp).

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "io/asset_stream.hpp"
#include "io/child_reader.hpp"
#include "io/decode_image.hpp"
#include "reader/assimp_reader.hpp"
#include "reader/image_reader.hpp"
#include "reader/limits.hpp"
#include "voxelize/vdb_io.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <new>

namespace elastogen {
namespace {

std::string all_input() {
  std::string bytes, block(1 << 16, '\0');
  for (;;) {
    const ssize_t n = ::read(STDIN_FILENO, block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return bytes;
    bytes.append(block, 0, size_t(n));
  }
}

/// The format without the name of a grid: "vdb:GRID".
std::string_view format_of(std::string_view word) {
  return word.substr(0, word.find(':'));
}

Asset read_file_of(const std::string& word, const std::string& path) {
  const std::string format(format_of(word));
  if (format != "vdb") return read_assimp(path, format);
  return read_vdb(path, word.size() > format.size() ? word.substr(format.size() + 1) : "");
}

std::string answer(const std::string& format, const std::string& path) {
  try {
    limit_process();
    const ThreadLimit single(1);  // the limit of CPU time counts all threads
    if (format == kImageWord) return encode_image(read_image(all_input(), std::stoi(path)));
    return encode_asset(read_file_of(format, path));
  } catch (const std::bad_alloc&) {
    return encode_failure(ReaderFailure::kMemory, "");
  } catch (const std::exception& error) {
    std::string_view text = error.what();
    if (text.starts_with(path + ": ")) text.remove_prefix(path.size() + 2);
    return encode_failure(ReaderFailure::kRefused, text);
  }
}

bool write_all(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    bytes.remove_prefix(size_t(n));
  }
  return true;
}

}  // namespace
}  // namespace elastogen

int main(int argc, char** argv) {
  const std::string_view format = argc == 3 ? argv[1] : "";
  if (format != elastogen::kImageWord &&
      !elastogen::is_child_format(elastogen::format_of(format))) {
    std::fprintf(stderr,
                 "usage: elastogen-reader FORMAT PATH, or image EDGE with the image as input\n");
    return 2;
  }
  // skip the libraries' clean-up, which could only fail
  ::_exit(elastogen::write_all(elastogen::answer(argv[1], argv[2])) ? 0 : 1);
}
