// SPDX-License-Identifier: Apache-2.0
#include "reader/limits.hpp"

#include "io/child_reader.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>

namespace elastogen {
namespace {

/// In a process of its own: limits it and ends with 0 if the call gives -1 and EPERM.
void expect_denied(const std::function<long()>& call, const char* what) {
  EXPECT_EXIT(
      {
        limit_process();
        errno = 0;
        ::_exit(call() == -1 && errno == EPERM ? 0 : 1);
      },
      testing::ExitedWithCode(0), "")
      << what;
}

TEST(Limits, NetworkProcessesAndWritingAreDenied) {
  const std::string file = testing::TempDir() + "elastogen_limits";
  std::fclose(std::fopen(file.c_str(), "w"));
  const char* path = file.c_str();
  char name[] = "sh", *words[] = {name, nullptr};
  expect_denied([] { return ::socket(AF_INET, SOCK_STREAM, 0); }, "socket");
  expect_denied([] { return ::socket(AF_UNIX, SOCK_STREAM, 0); }, "unix socket");
  expect_denied([] { return ::fork(); }, "fork");
  expect_denied([&] { return ::execv("/bin/sh", words); }, "execve");
  expect_denied([&] { return ::open(path, O_WRONLY); }, "write");
  expect_denied([&] { return ::open(path, O_RDWR); }, "read and write");
  expect_denied([&] { return ::open(path, O_RDONLY | O_TRUNC); }, "truncate");
  expect_denied([&] { return ::open((file + "2").c_str(), O_RDONLY | O_CREAT, 0666); }, "create");
  expect_denied([&] { return ::unlink(path); }, "unlink");
  expect_denied([&] { return ::rename(path, (file + "3").c_str()); }, "rename");
  expect_denied([&] { return ::mkdir((file + "4").c_str(), 0777); }, "mkdir");
  expect_denied([&] { return ::chmod(path, 0777); }, "chmod");
  expect_denied([] { return ::kill(::getppid(), 0); }, "kill");
  EXPECT_EQ(::access(path, F_OK), 0);
  ::unlink(path);
}

TEST(Limits, ThreadsMayStartAndEarlierOnesAreLimitedToo) {
  EXPECT_EXIT(
      {
        std::atomic<bool> limited = false;
        long earlier = 0;
        std::thread waiting([&] {
          limited.wait(false);
          earlier = ::socket(AF_INET, SOCK_STREAM, 0);
        });
        limit_process();
        limited = true;
        limited.notify_all();
        waiting.join();
        long later = 0;
        std::thread([&] { later = ::socket(AF_INET, SOCK_STREAM, 0); }).join();
        ::_exit(earlier == -1 && later == -1 ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(Limits, ReadingStaysAllowed) {
  EXPECT_EXIT(
      {
        limit_process();
        const int file = ::open("/proc/self/exe", O_RDONLY);
        char byte = 0;
        ::_exit(file >= 0 && ::read(file, &byte, 1) == 1 ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(Limits, MemoryEnds) {
#ifndef __SANITIZE_ADDRESS__
  EXPECT_EXIT(
      {
        limit_process();
        void* p = ::mmap(nullptr, size_t(kReaderMemory), PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        ::_exit(p == MAP_FAILED && errno == ENOMEM ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
#endif
}

TEST(Limits, TimeFilesAndCoresAreLimitedForGood) {
  EXPECT_EXIT(
      {
        limit_process();
        rlimit cpu = {};
        rlimit size = {};
        rlimit core = {};
        ::getrlimit(RLIMIT_CPU, &cpu);
        ::getrlimit(RLIMIT_FSIZE, &size);
        ::getrlimit(RLIMIT_CORE, &core);
        const bool hard =
            cpu.rlim_max == kReaderSeconds && size.rlim_max == 0 && core.rlim_max == 0;
        ::_exit(hard ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace elastogen
