// Rules for other programs and for papers.
#pragma once

#include <string>

#include "rules/rule.h"

namespace primo::rules {

/// The paper's layout in LaTeX (amsmath): a displayed formula for each rule, for each default rule a line.
std::string to_latex(const RuleSet& rules);

struct PpddlOptions {
  std::string domain = "primo";
  enum class Noise { no_change, dead_end } noise = Noise::no_change;  ///< what noise becomes, which PPDDL cannot say
};

struct Ppddl {
  std::string text;
  /// The largest probability that some rule gives to noise, which the domain gives to something else.
  double largest_noise = 0;
};

/// A PPDDL 1.0 domain (Younes and Littman 2004) with the semantics of the rules. Deictic variables are quantified
/// inside the effects, where the context singles them out; the outcome is drawn outside. A rule's effects happen where
/// it alone covers. Literals that all outcomes share stand before the choice. Derived predicates become axioms. Errors
/// (failed): what PPDDL cannot say: a function that loses its value, a count; names that differ only in case or in . :
/// / (config).
Result<Ppddl> to_ppddl(const RuleSet& rules, const PpddlOptions& options = {});

}  // namespace primo::rules
