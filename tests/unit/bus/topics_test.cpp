#include "bus/topics.h"

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "bus/dds_type.h"
#include "fixture.h"

namespace primo::bus {
namespace {

std::string stripped(std::string cell) {
  std::erase_if(cell, [](char c) { return c == ' ' || c == '`'; });
  return cell;
}

std::vector<std::string> page_rows() {
  std::ifstream page(std::string(PRIMO_SOURCE_DIR) + "/idl/topics.md");
  std::vector<std::string> rows;
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("| `rt/", 0) == 0) rows.push_back(line);
  }
  return rows;
}

TEST(Topics, are_those_of_the_page_with_the_same_types_qualities_keys_and_limits) {
  const auto rows = page_rows();
  ASSERT_EQ(rows.size(), topics().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TopicInfo& topic = topics()[i];
    std::vector<std::string> cells;
    std::stringstream line(rows[i]);
    for (std::string cell; std::getline(line, cell, '|');) cells.push_back(stripped(cell));
    ASSERT_GE(cells.size(), 7u) << rows[i];
    EXPECT_EQ(cells[1], topic.name);
    const auto slash = cells[2].find('/');
    const std::string package = slash == std::string::npos ? "primo_msgs" : cells[2].substr(0, slash);
    const std::string name = slash == std::string::npos ? cells[2] : cells[2].substr(slash + 1);
    EXPECT_EQ(package + "::msg::dds_::" + name + "_", topic.type);
    EXPECT_EQ(cells[3], to_string(topic.quality));
    EXPECT_EQ(cells[4], stripped(std::string(topic.key)));
    EXPECT_EQ(cells[5], std::to_string(topic.limit));
  }
}

TEST(Topics, carry_the_generated_type_they_say_keyed_exactly_where_they_say) {
  for (const TopicInfo& topic : topics()) {
    const auto type = generated_type(topic);
    EXPECT_EQ(type.get_type_name(), topic.type);
    EXPECT_EQ(type->m_isGetKeyDefined, !topic.key.empty()) << topic.name;
  }
}

TEST(Domain, comes_from_the_override_then_the_environment_then_the_settings) {
  BusSettings settings;
  settings.domain = 7;
  unsetenv("PRIMO_DOMAIN");
  EXPECT_EQ(effective_domain(settings).value(), 7);
  setenv("PRIMO_DOMAIN", "8", 1);
  EXPECT_EQ(effective_domain(settings).value(), 8);
  settings.domain_override = 9;
  EXPECT_EQ(effective_domain(settings).value(), 9);
  settings.domain_override.reset();
  for (const char* wrong : {"233", "-1", "12x", "x"}) {
    setenv("PRIMO_DOMAIN", wrong, 1);
    const auto domain = effective_domain(settings);
    ASSERT_FALSE(domain.ok()) << wrong;
    EXPECT_EQ(domain.error().code, Code::config);
    EXPECT_NE(domain.error().message.find("PRIMO_DOMAIN"), std::string::npos) << domain.error().message;
  }
  unsetenv("PRIMO_DOMAIN");
}

}  // namespace
}  // namespace primo::bus
