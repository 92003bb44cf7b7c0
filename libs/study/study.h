// Study files, and the complete study that a study's directory holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/config.h"
#include "motion/primitive.h"
#include "physics/verdict.h"
#include "scene/scenario.h"
#include "study/optimization.h"

namespace primo::study {

/// The scenarios in which experience is collected, with P and with P*: the training scenarios, each object displaced at
/// random.
struct ExperienceSettings {
  int scenarios = 60;
  double displacement = 0.02;
  std::uint64_t seed = 1001;
  template <class V>
  void visit(V&& v) {
    v("scenarios", scenarios, {.help = "displaced scenarios", .min = 1, .max = 100000});
    v("displacement", displacement,
      {.help = "uniform, on each axis in the plane, of every object", .unit = "m", .min = 0, .max = 0.5});
    v("seed", seed, {.help = "of the displacements and their jiggles; another than the study's"});
  }
};

struct SearchSettings {
  std::vector<std::string> algorithms = {"cma"};
  int evaluations = 600;
  int population = 0;
  double sigma = 0.3;
  std::string on_stagnation = "ipop";
  int restarts = 1;
  OptimizationSettings settings;
  template <class V>
  void visit(V&& v) {
    v("algorithms", algorithms, {.help = "run one after the other with the same budget; the best result wins"});
    v("evaluations", evaluations,
      {.help = "budget of γ evaluations, for each algorithm and restart", .min = 1, .max = 1e7});
    v("population", population,
      {.help = "candidates a generation; 0: the algorithm's default", .min = 0, .max = 10000});
    v("sigma", sigma, {.help = "initial step, fraction of the box's width", .min = 1e-6, .max = 2});
    v("on_stagnation", on_stagnation,
      {.help = "of cma: begin elsewhere with twice the population (ipop), with large and small ones in turn (bipop), "
               "with the same (again), or end (stop)",
       .choices = {"ipop", "bipop", "again", "stop"}});
    v("restarts", restarts, {.help = "random starts of each algorithm", .min = 1, .max = 10000});
    settings.visit(v);
  }
};

/// What is the same in a study file and in the complete study.
struct StudySettings {
  std::uint64_t seed = 1;
  int rounds = 1;
  std::vector<std::vector<std::string>> goal;  ///< literals over X, Y, … that the desired outcome must hold; empty: any
  ExperienceSettings experience;
  SearchSettings optimizer;
  physics::JudgeSettings judge;
  int executed = 12;
  template <class V>
  void visit(V&& v) {
    v("seed", seed, {.help = "of the optimization and its jiggles"});
    v("rounds", rounds, {.help = "at most this many rounds of learning and optimizing", .min = 1, .max = 100});
    v("goal", goal,
      {.help = "literals over X, Y, … that the desired outcome must hold, e.g. [[inhand, X]]; empty: the most probable "
               "change"});
    v("experience", experience, {});
    v("optimizer", optimizer, {});
    v("judge", judge, {});
    v("executed", executed,
      {.help = "plans executed in full physics at the end, with P and with P*", .min = 0, .max = 100000});
  }
  Status validate() const;
};

/// A study file (YAML). Paths are relative to it.
struct StudyFile {
  std::string name;
  std::string robot;
  std::string primitive;
  std::vector<std::string> training;
  StudySettings settings;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "letters, digits, _ and -", .required = true});
    v("robot", robot, {.help = "robot file, relative to this one", .required = true});
    v("primitive", primitive, {.help = "file of the hand-tuned primitive P", .required = true});
    v("training", training, {.help = "files of the training scenarios", .required = true});
    settings.visit(v);
  }
  Status validate() const;
};

/// A complete study: the file with all defaults, and the content of every file it names. What study.yaml in its
/// directory holds.
struct Study {
  std::string name;
  std::string robot;         ///< absolute path of the robot file
  std::string robot_digest;  ///< of the robot file, its model and their files (robot/files_digest.h)
  motion::Primitive primitive;
  std::vector<scene::Scenario> training;  ///< robot_start filled in
  StudySettings settings;

  /// The name and 8 digits over the whole content but the robot's path.
  std::string id() const;
  Status validate() const;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("robot", robot, {.help = "robot file", .required = true});
    v("robot_digest", robot_digest, {.help = "of the robot file and its model", .required = true});
    settings.visit(v);
    v("primitive", primitive, {.required = true});
    v("training", training, {.required = true});
  }
};

/// Reads a study file and every file it names. Errors name the file and line. `overrides` are "key=value", as in
/// config::override_keys.
Result<Study> load_study(const std::filesystem::path& study_file, const std::vector<std::string>& overrides = {});

/// Reads study.yaml of a study's directory.
Result<Study> read_study(const std::filesystem::path& directory);

enum class Adopted { created, resumed };

/// Makes `directory` this study's: creates it with study.yaml, or checks that the study.yaml there is of the same
/// study. Error (config): it is of another one; the first key that differs is named with both values.
Result<Adopted> adopt_directory(const Study& study, const std::filesystem::path& directory);

}  // namespace primo::study
