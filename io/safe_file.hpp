// SPDX-License-Identifier: Apache-2.0
// Files that are complete or absent, bounded reading, and paths that stay within their folder.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace elastogen {

/// Largest asset file that is read [bytes].
inline constexpr int64_t kMaxFileBytes = int64_t{1} << 32;

/// A file without a name in the folder of its target. commit() gives it the target's name; without
/// commit() nothing remains, even if the process is killed. (On file systems without nameless files
/// it has a temporary name, which the destructor removes.) A reader of the target sees the old file
/// or the complete new one.
/// @throws Error (resources) with path and reason, from every member.
class SafeFile {
 public:
  explicit SafeFile(const std::string& path);
  ~SafeFile();
  SafeFile(const SafeFile&) = delete;
  SafeFile& operator=(const SafeFile&) = delete;

  /// A path to the file for libraries that open files themselves. They must close it before
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

/// Path of a file that another file names, "tex/skin.png" beside it (backslashes are accepted). ""
/// unless it is a regular file that, after links are resolved, lies within that file's folder.
/// Absolute names and URLs give "".
std::string resolve_beside(const std::string& path, const std::string& name);

}  // namespace elastogen
