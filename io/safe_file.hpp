// SPDX-License-Identifier: Apache-2.0
// Files that are whole or absent, bounded reading, and paths that stay beneath their folder.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace elastogen {

/// Largest asset file that is read [bytes].
inline constexpr int64_t kMaxFileBytes = int64_t{1} << 32;

/// A file without a name in the folder of its target, which commit() gives it; without commit()
/// nothing remains, also where the process is killed. (On file systems that have no files without
/// a name: a temporary name, which destruction removes.) Whoever reads the target sees the old
/// file or the whole new one.
/// @throws Error (resources) with path and reason, from every member.
class SafeFile {
 public:
  explicit SafeFile(const std::string& path);
  ~SafeFile();
  SafeFile(const SafeFile&) = delete;
  SafeFile& operator=(const SafeFile&) = delete;

  /// A path to the file for libraries that open files themselves; they must have closed it before
  /// commit().
  const std::string& temporary() const { return temporary_; }
  /// The open file, for reading and writing.
  int descriptor() const { return file_; }
  /// Appends.
  void write(const void* data, size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Syncs the file, renames it, syncs the folder.
  void commit();

 private:
  [[noreturn]] void fail(const char* action) const;

  std::string path_, temporary_;
  int file_ = -1;
  bool named_ = false;  // temporary_ is a name in the folder
};

/// Writes a whole file through SafeFile.
void write_file(const std::string& path, std::string_view content);

/// The bytes of a regular file.
/// @throws Error (asset) if it is missing, a folder or a device, unreadable, or larger.
std::string read_file(const std::string& path, int64_t max_bytes = kMaxFileBytes);

/// Lower-case ending of a file's name without its dot, "" where it has none.
std::string ending_of(const std::string& path);

/// Path of a file that another file names, "tex/skin.png" beside it (backslashes are turned), or
/// "" unless it is a regular file that, links resolved, lies in that file's folder or below.
/// Absolute names and URLs give "".
std::string resolve_beside(const std::string& path, const std::string& name);

}  // namespace elastogen
