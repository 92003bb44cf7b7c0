#include "primo/interrupt.h"

#include <signal.h>

namespace primo::tool {
namespace {
volatile sig_atomic_t flag = 0;
void set_flag(int) { flag = 1; }
}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = set_flag;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return flag != 0; }

}  // namespace primo::tool
