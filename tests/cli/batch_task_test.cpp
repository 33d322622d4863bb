// SPDX-License-Identifier: Apache-2.0
#include "cli/batch_task.hpp"

#include "cli/options.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen {
namespace {

using Words = std::vector<std::string>;

BatchTask parsed(const Words& words) {
  std::vector<const char*> argv = {"elastogen", "animate"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  const CommandLine line = parse_command_line(int(argv.size()), argv.data());
  EXPECT_FALSE(line.animate);
  return line.batch.value();
}

TEST(BatchTask, TakesItsFilesAndJobsOutOfTheWords) {
  const Words files = {"a.toml", "b.toml"}, rest = {"animate", "--frames", "3", "--device", "cpu"};
  for (const Words& words :
       {Words{"--batch", "a.toml", "b.toml", "--frames", "3", "--jobs", "2", "--device", "cpu"},
        Words{"--frames", "3", "--jobs=2", "--device", "cpu", "--batch=a.toml", "b.toml"},
        Words{"--jobs", "2", "--frames", "3", "--batch", "a.toml", "--device", "cpu", "--batch",
              "b.toml"}}) {
    const BatchTask task = parsed(words);
    EXPECT_EQ(task.files, files);
    EXPECT_EQ(task.words, rest);
    EXPECT_EQ(task.jobs, 2);
    EXPECT_FALSE(task.quiet);
  }
}

TEST(BatchTask, KeepsAWordThatIsCalledAsAFileButIsNone) {
  const BatchTask task = parsed({"--batch", "foam", "--material", "foam", "--quiet"});
  EXPECT_EQ(task.files, Words{"foam"});
  EXPECT_EQ(task.words, (Words{"animate", "--material", "foam", "--quiet"}));
  EXPECT_TRUE(task.quiet);
}

}  // namespace
}  // namespace elastogen
