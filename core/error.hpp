// SPDX-License-Identifier: Apache-2.0
// The one exception of the library, and the check that throws it.

#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace elastogen {

/// Kinds of failure, which the command turns into exit codes (docs/user_guide.md).
enum class ErrorKind {
  kUsage,      ///< an option, a selection, a unit, a broken precondition: exit code 2
  kAsset,      ///< a file that cannot be used: exit code 3
  kDiverged,   ///< a step had to be refused: exit code 5
  kResources,  ///< memory, a budget, a disk: exit code 6
  kDevice,     ///< a device was asked for that is not there: exit code 7
};

/// Thrown for everything a caller can get wrong. The message names the object and the place.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, ErrorKind kind = ErrorKind::kUsage)
      : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// Joins its arguments into one string with operator<<.
template <class... Parts>
std::string concat(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

}  // namespace elastogen

/// Throws Error unless the condition holds; the other arguments are the message.
#define ELASTOGEN_CHECK(condition, ...) \
  do { \
    if (!(condition)) throw ::elastogen::Error(::elastogen::concat(__VA_ARGS__)); \
  } while (false)

/// ELASTOGEN_CHECK for an asset file (exit code 3).
#define ELASTOGEN_CHECK_ASSET(condition, ...) \
  do { \
    if (!(condition)) \
      throw ::elastogen::Error(::elastogen::concat(__VA_ARGS__), ::elastogen::ErrorKind::kAsset); \
  } while (false)
