// SPDX-License-Identifier: Apache-2.0
#include "io/child_process.hpp"

#include "core/error.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kReaderName = "elastogen-reader";
constexpr int kTickMilliseconds = 2;  ///< between polls of a process that closed its pipe

bool is_program(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

/// Settings of posix_spawn: standard input is a file or /dev/null, error is /dev/null, output is
/// the pipe, nothing else is open, signals are as at the start of a program.
class SpawnPlan {
 public:
  SpawnPlan(int input, int output) {
    posix_spawn_file_actions_init(&actions_);
    if (input >= 0)
      posix_spawn_file_actions_adddup2(&actions_, input, 0);
    else
      posix_spawn_file_actions_addopen(&actions_, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, 2, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, 1);
    posix_spawn_file_actions_addclosefrom_np(&actions_, 3);
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  /// 0 or an error number.
  int spawn(pid_t& process, const std::string& program, const char* const* words) const {
    return posix_spawn(&process, program.c_str(), &actions_, &attributes_,
                       const_cast<char* const*>(words), environ);
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

/// A running reader: its process and our end of the pipe. The destructor ends both.
class Child {
 public:
  Child(const std::string& program, const std::array<std::string, 2>& words, int input) {
    int ends[2];
    ELASTOGEN_CHECK_ASSET(::pipe2(ends, O_CLOEXEC) == 0, "no pipe: ", std::strerror(errno));
    pipe_ = ends[0];
    const char* const argv[] = {kReaderName, words[0].c_str(), words[1].c_str(), nullptr};
    const int error = SpawnPlan(input, ends[1]).spawn(process_, program, argv);
    ::close(ends[1]);
    if (error == 0) return;
    ::close(pipe_);
    throw Error(concat(program, " cannot be started: ", std::strerror(error)), ErrorKind::kAsset);
  }
  ~Child() {
    ::close(pipe_);
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// All bytes that it writes. @throws Error (asset) at the deadline and beyond max_bytes.
  std::string output(Clock::time_point deadline, const ChildOptions& options);
  /// The status of waitpid, once the process has ended. @throws Error (asset) at the deadline.
  int status(Clock::time_point deadline, const ChildOptions& options);

 private:
  int pipe_ = -1;
  pid_t process_ = -1;
};

std::string too_slow(double seconds) {
  return concat("reading it took more than ", seconds, " s; simplify it, or convert it to GLB");
}

std::string Child::output(Clock::time_point deadline, const ChildOptions& options) {
  std::string bytes, block(1 << 16, '\0');
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd waiting = {pipe_, POLLIN, 0};
    const int ready = left.count() > 0 ? ::poll(&waiting, 1, int(left.count())) : 0;
    if (ready < 0 && errno == EINTR) continue;
    ELASTOGEN_CHECK_ASSET(ready != 0, too_slow(options.seconds));
    const ssize_t n = ::read(pipe_, block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    ELASTOGEN_CHECK_ASSET(n >= 0, "the reader's pipe: ", std::strerror(errno));
    if (n == 0) return bytes;
    ELASTOGEN_CHECK_ASSET(n <= options.max_bytes - int64_t(bytes.size()), "it holds more than ",
                          options.max_bytes >> 20, " MiB of geometry; simplify it");
    bytes.append(block, 0, size_t(n));
  }
}

int Child::status(Clock::time_point deadline, const ChildOptions& options) {
  int status = 0;
  for (;;) {
    const pid_t ended = ::waitpid(process_, &status, WNOHANG);
    if (ended < 0 && errno == EINTR) continue;
    if (ended != 0) break;
    ELASTOGEN_CHECK_ASSET(Clock::now() < deadline, too_slow(options.seconds));
    ::poll(nullptr, 0, kTickMilliseconds);
  }
  process_ = -1;
  return status;
}

/// @throws Error (asset) unless the process ended by itself with 0.
void check_status(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    ELASTOGEN_CHECK_ASSET(signal != SIGXCPU, too_slow(kReaderSeconds));
    ELASTOGEN_CHECK_ASSET(signal != SIGKILL && signal != SIGTERM && signal != SIGINT,
                          "the reader was ended from outside (signal ", signal, ")");
    throw Error(concat("the reader crashed (signal ", signal,
                       "): the file is damaged, or it is more than the reader can do"),
                ErrorKind::kAsset);
  }
  ELASTOGEN_CHECK_ASSET(WEXITSTATUS(status) == 0, "the reader failed with exit code ",
                        WEXITSTATUS(status));
}

}  // namespace

std::string find_reader() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error && is_program(self.parent_path() / kReaderName))
    return (self.parent_path() / kReaderName).string();
  const char* named = std::getenv("ELASTOGEN_READER");
  if (named && is_program(named)) return named;
  ELASTOGEN_CHECK_ASSET(is_program(ELASTOGEN_INSTALLED_READER), "the program ", kReaderName,
                        " is needed for this format and is neither beside ", self.string(), " nor ",
                        ELASTOGEN_INSTALLED_READER,
                        "; set the environment variable ELASTOGEN_READER to its path");
  return ELASTOGEN_INSTALLED_READER;
}

std::string answer_of_reader(const std::array<std::string, 2>& words, int input,
                             const ChildOptions& options) {
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(options.seconds));
  Child child(options.program.empty() ? find_reader() : options.program, words, input);
  std::string bytes = child.output(deadline, options);
  check_status(child.status(deadline, options));
  return bytes;
}

}  // namespace elastogen
