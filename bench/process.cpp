// SPDX-License-Identifier: Apache-2.0
#include "bench/process.hpp"

#include "core/error.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>

namespace elastogen::bench {

int run_program(const std::string& program, const std::vector<std::string>& words) {
  constexpr int kNotStarted = 127;
  std::vector<std::string> all = {program};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  // not posix_spawn, whose child would count our peak memory as its own
  const pid_t child = fork();
  if (child < 0) return kNotStarted;
  if (child == 0) {
    dup2(STDERR_FILENO, STDOUT_FILENO);
    execvp(program.c_str(), arguments.data());
    _exit(kNotStarted);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return kNotStarted;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TemporaryFolder::TemporaryFolder() {
  std::error_code error;
  path_ = (std::filesystem::temp_directory_path(error) / "elastogen-bench-XXXXXX").string();
  if (error || !mkdtemp(path_.data()))
    throw Error(concat(path_, ": no folder for temporary files"), ErrorKind::kResources);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace elastogen::bench
