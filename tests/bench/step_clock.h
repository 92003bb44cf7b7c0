// Time inside MuJoCo's steps, measured from outside the judge: the linker puts this between the judge and mj_step1,
// mj_step2 (--wrap, see CMakeLists.txt). One thread.
#pragma once

#include <mujoco/mujoco.h>

#include <ctime>
#include <memory>

#include "bench/measure.h"

extern "C" {
void __real_mj_step1(const mjModel* model, mjData* data);  // NOLINT(bugprone-reserved-identifier)
void __real_mj_step2(const mjModel* model, mjData* data);  // NOLINT(bugprone-reserved-identifier)
void __wrap_mj_step1(const mjModel* model, mjData* data);  // NOLINT(bugprone-reserved-identifier)
void __wrap_mj_step2(const mjModel* model, mjData* data);  // NOLINT(bugprone-reserved-identifier)
}

namespace primo::bench {

struct StepClock {
  double inside_ms = 0;  ///< of both halves
  long steps = 0;
  /// Of every `replay_each`-th step: copies of its state, contacts, forces and warm start included, taken through a
  /// bare mj_step, in milliseconds. 0: none.
  int replay_each = 0;
  double replayed_ms = 0;
  long replayed = 0;

  struct Delete {
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::unique_ptr<mjData, Delete> copy;
  const mjModel* copied = nullptr;

  /// Of inside_ms. Wall time, as reading a thread's CPU time costs too much to do it twice a step: for shares of one
  /// run.
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
  }

  void replay(const mjModel* model, const mjData* data) {
    if (copied != model) copy.reset(mj_makeData(model));
    copied = model;
    double begin = 0;
    for (int k = 0; k < 3; ++k) {  // the last one counts: caches are warm then
      mj_copyData(copy.get(), model, data);
      begin = cpu_milliseconds();
      mj_step(model, copy.get());
    }
    replayed_ms += cpu_milliseconds() - begin;
    ++replayed;
  }
};

inline StepClock step_clock;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace primo::bench

void __wrap_mj_step1(const mjModel* model, mjData* data) {
  const double begin = primo::bench::StepClock::now();
  __real_mj_step1(model, data);
  primo::bench::step_clock.inside_ms += primo::bench::StepClock::now() - begin;
}

void __wrap_mj_step2(const mjModel* model, mjData* data) {
  auto& clock = primo::bench::step_clock;
  if (clock.replay_each > 0 && clock.steps % clock.replay_each == 0) clock.replay(model, data);
  ++clock.steps;
  const double begin = primo::bench::StepClock::now();
  __real_mj_step2(model, data);
  clock.inside_ms += primo::bench::StepClock::now() - begin;
}
