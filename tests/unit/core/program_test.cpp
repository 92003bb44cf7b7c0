#include "core/program.h"

#include <gtest/gtest.h>

namespace primo {
namespace {

TEST(Program, gives_what_it_wrote_and_how_it_ended) {
  const auto done = run_program({"sh", "-c", "pwd; echo \"$0\" >&2; cat; exit 7", "a 'word'"}, "/");
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->exit, 7);
  EXPECT_EQ(done->output, "/\na 'word'\n") << "no input, no shell between";
}

TEST(Program, that_does_not_exist_is_named) {
  const auto done = run_program({"no-such-program-of-primo"});
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, Code::unavailable);
  EXPECT_NE(done.error().message.find("no-such-program-of-primo"), std::string::npos);
}

TEST(Program, that_writes_without_end_is_read_to_its_end_but_not_kept) {
  const auto done = run_program({"sh", "-c", "head -c 3000000 /dev/zero; kill -9 $$"});
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(done->output.size(), Finished::kMostOutput);
  EXPECT_EQ(done->exit, 128);
}

}  // namespace
}  // namespace primo
