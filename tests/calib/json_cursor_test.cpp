#include "calib/json_cursor.h"

#include <ctime>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::json_cursor_test {
namespace {

std::string Refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const JsonError& error) {
    return error.what();
  }
  return "accepted";
}

std::string ParseRefusal(std::string_view text) {
  return Refusal([&] { ParseJson(text, "x.json"); });
}

TEST(Json, SaysWhereItStopsBeingJson) {
  EXPECT_EQ(ParseRefusal("{\n \"a\": 1,\n \"b\": }"),
            "x.json: line 3, column 7: expected valid JSON in UTF-8, found \"}\"");
  EXPECT_EQ(ParseRefusal(""),
            "x.json: line 1, column 1: expected valid JSON in UTF-8, found the end of the text");
  EXPECT_THAT(ParseRefusal("{\"a\": [1, NaN]}"), testing::HasSubstr("found \"NaN\""));
  EXPECT_THAT(ParseRefusal("{\"a\": 1 \"b\": 2}"), testing::HasSubstr("found \"b\""));
  EXPECT_THAT(ParseRefusal("{\"a\": -Infinity}"), testing::HasSubstr("found \"-Infinity\""));
  EXPECT_EQ(ParseRefusal("{\"a\": 1} trailing").find("x.json: line 1, column 1"), 0u);
}

TEST(Json, RefusesBytesThatAreNotUtf8InOneLine) {
  for (const std::string_view text :
       {"{\"a\": \"\xff\xfe\"}", "\xc3(", "{\"\n\": 1}", "[\"\xed\xa0\x80\"]"}) {
    const std::string refusal = ParseRefusal(text);
    EXPECT_NE(refusal, "accepted");
    EXPECT_EQ(refusal.find('\n'), std::string::npos);
  }
}

TEST(Json, RefusesHugeNestingWithoutOverflowingTheStack) {
  EXPECT_NE(ParseRefusal(std::string(1'000'000, '[')).find("64 levels"), std::string::npos);
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_NE(ParseRefusal(objects).find("64 levels"), std::string::npos);
  const std::string allowed = std::string(64, '[') + std::string(64, ']');
  EXPECT_NO_THROW(ParseJson(allowed, "x.json"));
}

TEST(Json, RefusesNumbersThatNothingHolds) {
  EXPECT_NE(ParseRefusal("{\"a\": 1e999}").find("too large"), std::string::npos);
  EXPECT_NE(ParseRefusal("{\"a\": NaN}"), "accepted");
}

TEST(Json, RefusesAKeyGivenTwice) {
  EXPECT_EQ(ParseRefusal(R"({"a": {"b": 1}, "c": [{"b": 1}, {"b": 1, "b": 2}]})"),
            "x.json: expected each key once, found \"b\" twice");
}

// A walk over the list at each of its objects would be 2e10 steps: 11 s of one core.
TEST(Json, ParsesALongListOfObjectsInLinearTime) {
  constexpr std::size_t kObjects = 200'000;
  std::string list = "[{}";
  for (std::size_t i = 1; i < kObjects; ++i) list += ",{}";
  const std::clock_t begin = std::clock();
  EXPECT_EQ(ParseJson(list + "]", "x.json").size(), kObjects);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 5.0);
}

TEST(JsonCursor, NamesFilePathAndExpectation) {
  const nlohmann::json document =
      ParseJson(R"({"camera": {"fx": [1, "x"]}, "deep": [[1]]})", "s.json");
  const JsonCursor root(document, "s.json");
  const JsonCursor second = root.Required("camera").Required("fx").List(2, 2)[1];
  EXPECT_EQ(Refusal([&] { second.PositiveNumber(); }),
            "s.json: camera.fx[1]: expected a positive number, found \"x\"");
  EXPECT_EQ(Refusal([&] { root.Required("camera").Required("fy"); }),
            "s.json: camera.fy: expected a value, found none");
  EXPECT_EQ(Refusal([&] { root.Required("deep").Text(); }),
            "s.json: deep: expected a text, found a list of 1");
  EXPECT_EQ(Refusal([&] { root.CheckKeys({"camera"}); }),
            "s.json: expected only known keys (\"camera\"), found \"deep\"");
  EXPECT_EQ(Refusal([&] { root.Text(); }), "s.json: expected a text, found an object");
}

// What a person notes down is a number, a list or an object as often as text.
TEST(JsonCursor, LetsFreeKeysPassWhateverTheyHold) {
  const nlohmann::json document = ParseJson(
      R"({"note": "a", "note_x": 3, "formula2": ["c", 1], "world": {"up": "+Z"}, "name": null})",
      "s.json");
  const JsonCursor root(document, "s.json");
  EXPECT_NO_THROW(root.CheckKeys({}));
  EXPECT_EQ(root.Required("note").FreeText(), "a");
  EXPECT_EQ(root.Required("name").FreeText(), "");
  const nlohmann::json other = ParseJson(R"({"my_note": "a"})", "s.json");
  EXPECT_THROW(JsonCursor(other, "s.json").CheckKeys({}), JsonError);
}

TEST(JsonCursor, ChecksRanges) {
  const nlohmann::json document = ParseJson(R"([0, -1, 1e-320, 2.5, 480.0, 1e300])", "s.json");
  const auto entries = JsonCursor(document, "s.json").List(0, 10);
  EXPECT_THROW(entries[0].PositiveNumber(), JsonError);
  EXPECT_THROW(entries[1].PositiveNumber(), JsonError);
  EXPECT_THROW(entries[2].PositiveNumber(), JsonError);
  EXPECT_THROW(entries[3].IntegerIn(1, 10), JsonError);
  EXPECT_EQ(entries[4].IntegerIn(1, 1000), 480);
  EXPECT_THROW(entries[5].IntegerIn(1, 1000), JsonError);
  EXPECT_THROW(entries[3].NumberIn(3.0, 4.0), JsonError);
  EXPECT_EQ(entries[3].NumberIn(2.0, 4.0), 2.5);
}

TEST(JsonCursor, QuotesWhatItFoundInOneShortLine) {
  const nlohmann::json document = nlohmann::json::array({"a\nb" + std::string(500, 'z')});
  const std::string refusal =
      Refusal([&] { JsonCursor(document, "s.json").List(1, 1)[0].Number(); });
  EXPECT_EQ(refusal.find('\n'), std::string::npos);
  EXPECT_LT(refusal.size(), 150u);
}

}  // namespace
}  // namespace pleinair::json_cursor_test
