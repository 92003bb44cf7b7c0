// Study files, and the complete study that a study's directory holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "motion/primitive.h"
#include "physics/verdict.h"
#include "scene/scenario.h"
#include "study/optimization.h"
#include "study/pool.h"

namespace primo::study {

/// The scenarios in which experience is collected, with P and with P*: the training scenarios, each object displaced at
/// random.
struct ExperienceSettings {
  int scenarios = 60;
  double displacement = 0.02;
  std::uint64_t seed = 1001;
  physics::Mode mode = physics::Mode::final_pose;
  template <class V>
  void visit(V&& v) {
    v("scenarios", scenarios, {.help = "displaced scenarios", .min = 1, .max = 100000});
    v("displacement", displacement,
      {.help = "uniform, on each axis in the plane, of every object", .unit = "m", .min = 0, .max = 0.5});
    v("seed", seed, {.help = "of the displacements and their jiggles; another than the study's"});
    v("mode", mode,
      {.help = "what the rules are learned from: final_pose, as in the paper, or execute, the whole motion in physics, "
               "in which pushes, falls and dropped objects are outcomes of their own"});
  }
};

/// The held-out scenarios on which P and P* are compared in the end (paper, Figures 3 and 6): the training scenarios,
/// displaced by more and more. Nothing is chosen by them.
struct GeneralizationSettings {
  std::vector<double> levels;
  int scenarios = 200;
  int executed = 0;
  std::vector<double> tables;
  std::uint64_t seed = 2001;
  template <class V>
  void visit(V&& v) {
    v("levels", levels,
      {.help = "displacements, uniform in ± of each; empty: none", .unit = "m", .min = 0, .max = 0.5});
    v("scenarios", scenarios, {.help = "of each level", .min = 1, .max = 100000});
    v("executed", executed,
      {.help = "so many of each level are also executed in full physics", .min = 0, .max = 100000});
    v("tables", tables,
      {.help = "levels at which rules are learned too (paper, Tables I and II)", .unit = "m", .min = 0, .max = 0.5});
    v("seed", seed, {.help = "of the displacements and their jiggles; another than all others"});
  }
  Status validate() const;
};

struct SearchSettings {
  std::vector<std::string> algorithms = {"cma"};
  int evaluations = 600;
  int population = 0;
  double sigma = 0.3;
  std::string on_stagnation = "ipop";
  int patience = 20;
  double least_rise = 0.01;
  int restarts = 1;
  int later_restarts = 0;
  OptimizationSettings settings;
  template <class V>
  void visit(V&& v) {
    v("algorithms", algorithms, {.help = "run one after the other with the same budget; the best result wins"});
    v("evaluations", evaluations,
      {.help = "budget of γ evaluations, for each algorithm and restart", .min = 1, .max = 1e7});
    optim::visit_search(v, *this);
    v("least_rise", least_rise, {.help = "of γ, what counts as a rise", .min = 0, .max = 10});
    v("restarts", restarts, {.help = "random starts of each algorithm", .min = 1, .max = 10000});
    v("later_restarts", later_restarts,
      {.help =
           "of rounds after the first, in which the primitive found before stands for election too; 0: as many as in "
           "the first",
       .min = 0,
       .max = 10000});
    settings.visit(v);
  }
  /// Those of one search with the first algorithm.
  optim::OptimizerSettings of_optimizer() const {
    return {.name = algorithms.front(),
            .evaluations = evaluations,
            .population = population,
            .sigma = sigma,
            .on_stagnation = on_stagnation,
            .patience = patience,
            .least_rise = least_rise};
  }
};

/// How one part of a study is done: what is the same in a study file and in the complete study.
struct StudySettings {
  std::uint64_t seed = 1;
  int rounds = 1;
  std::vector<std::vector<std::string>> goal;  ///< literals over X, Y, … that the desired outcome must hold; empty: any
  Protocol protocol = Protocol::paper;
  PoolSettings pool;
  ExperienceSettings experience;
  SearchSettings optimizer;
  physics::JudgeSettings judge;
  int executed = 12;
  GeneralizationSettings generalization;
  template <class V>
  void visit(V&& v) {
    v("seed", seed, {.help = "of the optimization and its jiggles"});
    v("rounds", rounds, {.help = "at most this many rounds of learning and optimizing", .min = 1, .max = 100});
    v("goal", goal,
      {.help = "literals over X, Y, … that the desired outcome must hold, e.g. [[inhand, X]]; empty: the most probable "
               "change"});
    v("protocol", protocol,
      {.help = "paper: trained on the fixed training scenarios; robust: on displaced copies of them (pool), drawn anew "
               "for each generation, with as many rollouts"});
    v("pool", pool, {});
    v("experience", experience, {});
    v("optimizer", optimizer, {});
    v("judge", judge, {});
    v("executed", executed,
      {.help = "plans executed in full physics at the end, with P and with P*", .min = 0, .max = 100000});
    v("generalization", generalization, {});
  }
  Status validate() const;
};

/// One action's primitive P, optimized by one protocol.
struct Part {
  std::string name;  ///< letters, digits, _ and -
  motion::Primitive primitive;
  /// What the search of the first round begins with in place of P: another set of task variables and profiles. Open
  /// entries are searched; P remains what is compared with.
  std::optional<motion::Primitive> structure = {};
  std::vector<scene::Scenario> training;  ///< robot_start filled in
  StudySettings settings;

  Status validate() const;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    settings.visit(v);
    v("primitive", primitive, {.required = true});
    v("structure", structure, {.help = "primitive whose open entries are searched in place of P's"});
    v("training", training, {.required = true});
  }
};

/// A complete study: the file with all defaults, and the content of every file it names. What study.yaml in its
/// directory holds.
struct Study {
  std::string name;
  std::string robot;         ///< absolute path of the robot file
  std::string robot_digest;  ///< of the robot file, its model and their files (robot/files_digest.h)
  std::vector<Part> parts;

  /// The name and 8 digits over the whole content but the robot's path.
  std::string id() const;
  Status validate() const;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("robot", robot, {.help = "robot file", .required = true});
    v("robot_digest", robot_digest, {.help = "of the robot file and its model", .required = true});
    v("parts", parts, {.required = true});
  }
};

/// Reads a study file (YAML) and every file it names; paths are relative to the file they stand in. Keys:
///   include   a file or a list of them; their keys hold where this file does not say otherwise
///   name      of the study
///   robot     robot file
///   parts     a list of maps, each with the keys of a part: name, primitive (a file), structure (a file), training
///             (files of scenarios), and the settings; what stands beside `parts` holds for all of them. Without
///             `parts` the file is one part itself, named after its action.
/// Maps are merged key by key, anything else is replaced whole. `overrides` are "key=value", e.g.
/// "optimizer.evaluations=500" for all parts, "grasp.optimizer.evaluations=500" for the part named grasp. Errors name
/// the file, the line where there is one, and the key.
Result<Study> load_study(const std::filesystem::path& study_file, const std::vector<std::string>& overrides = {});

/// Every key of a study file with its default, unit, bounds and meaning.
std::string describe_study_file();

/// Reads study.yaml of a study's directory.
Result<Study> read_study(const std::filesystem::path& directory);

enum class Adopted { created, resumed };

/// Makes `directory` this study's: creates it with study.yaml, or checks that the study.yaml there is of the same
/// study. Error (config): it is of another one; the first key that differs is named with both values.
Result<Adopted> adopt_directory(const Study& study, const std::filesystem::path& directory);

/// The keys in which two complete studies differ, with both values ("(nothing)" where one lacks it), sorted. Where the
/// robot file lies does not count.
struct Distinct {
  std::string key, first, second;
};
Result<std::vector<Distinct>> differences(const Study& first, const Study& second);

}  // namespace primo::study
