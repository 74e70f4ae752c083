// Editing a site's file: what is changed, and what stays.
#include <filesystem>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/site_file.h"
#include "tests/scene/file_size_limit.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_file_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;

TEST(SiteFile, AnEditKeepsAllOtherKeysWithTheirOrderAndValues) {
  const TemporaryFolder folder;
  folder.Write("sequence.json",
               R"({"z": 0.1, "note": "\u00fc", "a": [1, 2.5, -0.0, 1e-320, 18446744073709551615],
                   "camera": {"width": 3, "fx": 0.30000000000000004}, "b": null})");
  EditSiteFile(folder.Path(), [](Json& json) {
    json["camera"]["width"] = 4;
    json["new"] = true;
  });
  EXPECT_EQ(Json::parse(ContentOf(folder / "sequence.json")).dump(),
            R"({"z":0.1,"note":"ü","a":[1,2.5,-0.0,1e-320,18446744073709551615],)"
            R"("camera":{"width":4,"fx":0.30000000000000004},"b":null,"new":true})");
  EXPECT_EQ(folder.FileCount(), 1u);
}

TEST(SiteFile, ASitesOwnFileComesBeforeASequences) {
  const TemporaryFolder folder;
  folder.Write("sequence.json", "{}");
  folder.Write("site.json", "{}");
  EXPECT_EQ(SiteFileIn(folder.Path()), folder / "site.json");
  EditSiteFile(folder.Path(), [](Json& json) { json["key"] = 1; });
  EXPECT_EQ(Json::parse(ContentOf(folder / "site.json")), Json({{"key", 1}}));
  EXPECT_EQ(ContentOf(folder / "sequence.json"), "{}");
  // Named itself, the other one is meant.
  EditSiteFile(folder / "sequence.json", [](Json& json) { json["other"] = 2; });
  EXPECT_EQ(Json::parse(ContentOf(folder / "sequence.json")), Json({{"other", 2}}));
  EXPECT_EQ(Json::parse(ContentOf(folder / "site.json")), Json({{"key", 1}}));
}

TEST(SiteFile, AnEditThatChangesNothingWritesNothing) {
  const TemporaryFolder folder;
  const std::string text = "{ \"key\" :  1 }";
  folder.Write("site.json", text);
  EditSiteFile(folder.Path(), [](Json& json) { json["key"] = 1; });
  EXPECT_EQ(ContentOf(folder / "site.json"), text);
}

TEST(SiteFile, AnEditThatFailsLeavesTheFile) {
  const TemporaryFolder folder;
  folder.Write("site.json", "{}");
  EXPECT_THROW(EditSiteFile(folder.Path(),
                            [](Json& json) {
                              json["key"] = 1;
                              throw std::runtime_error("no");
                            }),
               std::runtime_error);
  EXPECT_EQ(ContentOf(folder / "site.json"), "{}");
}

TEST(SiteFile, RefusalsAreOneLineWithTheFile) {
  const TemporaryFolder folder;
  const auto refusal = [&] {
    std::string text =
        MessageOf([&] { EditSiteFile(folder.Path(), [](Json& json) { json["key"] = 1; }); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  };
  EXPECT_THAT(refusal(), HasSubstr("expected a site's folder"));
  folder.Write("site.json", "[1]");
  EXPECT_THAT(refusal(), HasSubstr("site.json: expected an object"));
  folder.Write("site.json", "{\"a\": 1, \"a\": 2}");
  EXPECT_THAT(refusal(), HasSubstr("expected each key once"));
  fs::remove(folder / "site.json");
  fs::create_symlink("/proc/version", folder / "site.json");
  EXPECT_THAT(refusal(), HasSubstr("expected a file inside"));
}

// A full disc, as the system's limit of a file's size makes one; permissions do not stop root.
TEST(SiteFile, WhatCannotBeWrittenLeavesTheFile) {
  const TemporaryFolder folder;
  folder.Write("site.json", "{}");
  const std::string text = [&] {
    const FileSizeLimit limit(0);
    return MessageOf([&] { EditSiteFile(folder.Path(), [](Json& json) { json["key"] = 1; }); });
  }();
  EXPECT_THAT(text, HasSubstr("site.json: cannot be written: "));
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  EXPECT_EQ(ContentOf(folder / "site.json"), "{}");
  EXPECT_EQ(folder.FileCount(), 1u);
}

}  // namespace
}  // namespace pleinair::site_file_test
