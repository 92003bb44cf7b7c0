// What the sub-verbs of `primo rules` share: their files.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "rules/rule.h"
#include "symbols/experience_file.h"

namespace primo::tool {

/// `primo rules show|export|plan|diagnose|diff`, under the verb `rules`.
void add_rules_use(CLI::App& rules, int& exit);

/// A file of rules. Error: its name, and what is wrong where.
Result<rules::RuleSet> read_rules(const std::string& file);

/// Gives every experience of the files to `use`. Skipped lines are counted on standard error.
Status read_all(const std::vector<std::string>& files, bool skip_bad,
                const std::function<Status(symbols::Experience&&, const std::string& where)>& use);

/// As read_all(), of experiences that rules are applied to: a name that the rules use otherwise is an error.
Status read_all_for(const rules::RuleSet& rules, const std::vector<std::string>& files, bool skip_bad,
                    const std::function<Status(symbols::Experience&&, const std::string& where)>& use);

}  // namespace primo::tool
