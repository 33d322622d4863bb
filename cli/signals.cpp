// SPDX-License-Identifier: Apache-2.0
#include "cli/signals.hpp"

#include <signal.h>
#include <unistd.h>

namespace elastogen {

namespace {

volatile sig_atomic_t pending = 0;

extern "C" void remember(int signal) {
  if (pending != 0) _exit(128 + signal);
  pending = signal;
}

}  // namespace

void watch_signals() {
  struct sigaction action = {};
  action.sa_handler = remember;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int pending_signal() {
  return pending;
}

}  // namespace elastogen
