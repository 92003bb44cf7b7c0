// Pieces that the report's sections share. Private to libs/study.
#pragma once

#include "study/report_material.h"

namespace primo::study {

using symbols::Literal;

/// "inhand(X), ¬on(X,Y)" as HTML.
std::string literals(const std::vector<Literal>& list);

/// An outcome of a rule: its probability, what it says, its count and interval.
std::string outcome_row(double p, const std::string& what, const Rate& rate);

/// The action's rule in the form of the paper's tables. `side` is before or after; `untested`: context that always
/// held.
std::string rule_box(const PartMaterial& m, const rules::RuleSet& rules, const char* side, const std::string& title,
                     const std::vector<Literal>& untested = {});

/// Everything about the held-out scenarios. @pre the part has levels.
std::string held_out_sections(const PartMaterial& m);

}  // namespace primo::study
