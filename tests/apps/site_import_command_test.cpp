#include "apps/site_import_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::site_import_command_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Arguments are checked before anything is read.
std::string RefusalOf(const SiteImportCommandOptions& options) {
  std::string refusal = MessageOf([&] { RunSiteImport(options); });
  EXPECT_THAT(refusal, Not(HasSubstr("\n")));
  return refusal;
}

TEST(SiteImportCommand, NamesTheArgumentThatIsWrong) {
  SiteImportCommandOptions options;
  options.import.reconstruction = "no such model";
  options.length_m = 2.0;
  EXPECT_THAT(RefusalOf(options), HasSubstr("--between"));
  for (const char* between : {"1", "1,x", "a.jpg,1,2,3", "a.jpg,1,2,3,x", "1,2,3"}) {
    options.between = between;
    EXPECT_THAT(RefusalOf(options), HasSubstr("--between")) << between;
  }
  options.between = "1,2";
  EXPECT_THAT(RefusalOf(options), HasSubstr("no such model"));
  options.between = "a.jpg,1,2,3.5,4";
  EXPECT_THAT(RefusalOf(options), HasSubstr("no such model"));
  for (const char* heading : {"a.jpg", "a.jpg,x", "a.jpg,400", "a.jpg,10,0", "a.jpg,1,2,3"}) {
    options.headings = {heading};
    EXPECT_THAT(RefusalOf(options), HasSubstr("--heading")) << heading;
  }
  options.headings = {"a.jpg,-10,3"};
  for (const char* offset : {"2", "+2h", "+25:00"}) {
    options.utc_offset = offset;
    EXPECT_THAT(RefusalOf(options), HasSubstr("--utc-offset")) << offset;
  }
  options.utc_offset = "-03:30";
  EXPECT_THAT(RefusalOf(options), HasSubstr("no such model"));
}

TEST(SiteImportCommand, NamesTheLineOfATable) {
  const TemporaryFolder folder;
  SiteImportCommandOptions options;
  options.import.reconstruction = "no such model";
  options.times =
      folder.Write("times.csv", "picture,time\na.jpg,2026-06-21T10:00:00Z\nb.jpg,noon\n");
  EXPECT_THAT(RefusalOf(options), HasSubstr("times.csv:3"));
  options.times = folder.Write("times.csv", "# UTC\na.jpg, 2026-06-21T10:00:00Z, more\n");
  options.marks = folder.Write("marks.csv", "a.jpg,1,2,wall\na.jpg,1,x,wall\n");
  EXPECT_THAT(RefusalOf(options), HasSubstr("marks.csv:2"));
  options.marks = folder.Write("marks.csv", "a.jpg,1,2,north wall\n");
  EXPECT_THAT(RefusalOf(options), AllOf(HasSubstr("marks.csv:1"), HasSubstr("one word")));
  options.marks = folder.Write("marks.csv", "# none\n");
  EXPECT_THAT(RefusalOf(options), HasSubstr("marks.csv"));
  options.marks = folder.Write("marks.csv", "a.jpg,1,2,wall\n");
  EXPECT_THAT(RefusalOf(options), HasSubstr("no such model"));
}

}  // namespace
}  // namespace pleinair::site_import_command_test
