// SPDX-License-Identifier: Apache-2.0
#include "reader/limits.hpp"

#include "core/error.hpp"
#include "io/child_reader.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <malloc.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <vector>

namespace elastogen {
namespace {

constexpr rlim_t kOpenFiles = 32;

#if defined(__x86_64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_X86_64;
constexpr uint32_t kForeignCalls = 0x40000000;  ///< first call of the x32 interface
#elif defined(__aarch64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
constexpr uint32_t kForeignCalls = 0xffffffff;
#else
#error "reader/limits.cpp knows the system calls of x86-64 and AArch64"
#endif

/// System calls that are denied.
constexpr uint32_t kDenied[] = {
    // network
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendto,
    SYS_sendmsg,
    // other processes
    SYS_execve,
    SYS_execveat,
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_pidfd_open,
    SYS_kill,
    SYS_unshare,
    SYS_setns,
    // names and files
    SYS_unlinkat,
    SYS_renameat,
    SYS_renameat2,
    SYS_mkdirat,
    SYS_mknodat,
    SYS_linkat,
    SYS_symlinkat,
    SYS_truncate,
    SYS_ftruncate,
    SYS_fchmod,
    SYS_fchmodat,
    SYS_fchown,
    SYS_fchownat,
    SYS_mount,
    SYS_chroot,
    // calls that circumvent a filter, and large parts of the kernel
    SYS_openat2,
    SYS_io_uring_setup,
    SYS_bpf,
    SYS_userfaultfd,
    SYS_perf_event_open,
    SYS_keyctl,
    SYS_add_key,
    SYS_memfd_create,
#ifdef __x86_64__
    SYS_fork,
    SYS_vfork,
    SYS_creat,
    SYS_unlink,
    SYS_rename,
    SYS_mkdir,
    SYS_rmdir,
    SYS_mknod,
    SYS_link,
    SYS_symlink,
    SYS_chmod,
    SYS_chown,
#endif
};

void limit(__rlimit_resource resource, rlim_t value, const char* what) {
  const rlimit both = {value, value};
  if (::setrlimit(resource, &both) != 0)
    throw Error(concat("cannot limit ", what, ": ", std::strerror(errno)), ErrorKind::kResources);
}

// instructions of the classic packet filter
sock_filter load(size_t at) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, uint32_t(at));
}
sock_filter jump(uint16_t test, uint32_t value, uint8_t yes, uint8_t no) {
  return BPF_JUMP(uint16_t(BPF_JMP | BPF_K | test), value, yes, no);
}
sock_filter answer(uint32_t value) {
  return BPF_STMT(BPF_RET | BPF_K, value);
}

/// The filter as instructions of the classic packet filter. Calls of foreign architectures end the
/// process. Denied calls, opening for writing and new processes fail. Threads may start by clone;
/// clone3 is reported as not existing, because a filter cannot see its flags.
std::vector<sock_filter> filter() {
  constexpr uint32_t kFail = SECCOMP_RET_ERRNO | EPERM;
  constexpr uint32_t kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;

  std::vector<sock_filter> f;
  f.push_back(load(offsetof(seccomp_data, arch)));
  f.push_back(jump(BPF_JEQ, kArchitecture, 1, 0));
  f.push_back(answer(SECCOMP_RET_KILL_PROCESS));
  f.push_back(load(offsetof(seccomp_data, nr)));
  f.push_back(jump(BPF_JGE, kForeignCalls, 0, 1));
  f.push_back(answer(SECCOMP_RET_KILL_PROCESS));
  for (const uint32_t call : kDenied) {
    f.push_back(jump(BPF_JEQ, call, 0, 1));
    f.push_back(answer(kFail));
  }
  // a call fails if the low 32 bits of an argument have one of the bits, or else if they have none
  const auto deny_bits = [&](uint32_t call, int argument, uint32_t bits, bool if_set) {
    f.push_back(jump(BPF_JEQ, call, 0, 4));
    f.push_back(load(offsetof(seccomp_data, args) + 8 * size_t(argument)));
    f.push_back(jump(BPF_JSET, bits, if_set ? 0 : 1, if_set ? 1 : 0));
    f.push_back(answer(kFail));
    f.push_back(answer(SECCOMP_RET_ALLOW));
  };
#ifdef __x86_64__
  deny_bits(SYS_open, 1, kWriting, true);
#endif
  deny_bits(SYS_openat, 2, kWriting, true);
  deny_bits(SYS_clone, 0, CLONE_THREAD, false);
  f.push_back(jump(BPF_JEQ, SYS_clone3, 0, 1));
  f.push_back(answer(SECCOMP_RET_ERRNO | ENOSYS));
  f.push_back(answer(SECCOMP_RET_ALLOW));
  return f;
}

}  // namespace

void limit_process() {
  limit(RLIMIT_CPU, kReaderSeconds, "the CPU time");
  limit(RLIMIT_FSIZE, 0, "the size of files");
  limit(RLIMIT_CORE, 0, "core dumps");
  limit(RLIMIT_NOFILE, kOpenFiles, "open files");
#ifndef __SANITIZE_ADDRESS__  // whose runtime reserves terabytes of addresses
  limit(RLIMIT_AS, rlim_t(kReaderMemory), "the memory");
#endif
  ::mallopt(M_ARENA_MAX, 1);  // each further arena reserves 64 MiB of addresses

  // libraries have started threads already, so the filter applies to all threads
  std::vector<sock_filter> instructions = filter();
  const sock_fprog program = {static_cast<unsigned short>(instructions.size()),
                              instructions.data()};
  const bool done =
      ::prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
      ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program) == 0;
  if (!done)
    throw Error(concat("cannot enter the sandbox: ", std::strerror(errno)), ErrorKind::kResources);
}

}  // namespace elastogen
