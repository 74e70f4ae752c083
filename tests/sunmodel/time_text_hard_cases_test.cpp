#include <stdexcept>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/time_text.h"

namespace pleinair::time_text_hard_cases_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Quoted(std::string_view text) {
  std::string quoted(1, '\'');
  quoted += text;
  quoted += '\'';
  return quoted;
}

std::string ErrorOf(const std::string& text) {
  try {
    ParseUtcTime(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(TimeTextHardCases, KnowsLeapDays) {
  EXPECT_EQ(ParseUtcTime("2000-02-29T00:00:00Z"), sys_days(2000y / 2 / 29));
  EXPECT_EQ(ParseUtcTime("2024-02-29T00:00:00Z"), sys_days(2024y / 2 / 29));
  EXPECT_THAT(ErrorOf("1900-02-29T00:00:00Z"), HasSubstr("day is 29"));
  EXPECT_THAT(ErrorOf("2023-02-29T00:00:00Z"), HasSubstr("day is 29"));
  EXPECT_THAT(ErrorOf("2023-04-31T00:00:00Z"), HasSubstr("day is 31"));
}

TEST(TimeTextHardCases, TakesSecond60OnlyWhereUtcHadOne) {
  EXPECT_EQ(ParseUtcTime("2016-12-31T23:59:60Z"), sys_days(2017y / 1 / 1));
  EXPECT_EQ(ParseUtcTime("2016-12-31T23:59:60.75Z"), sys_days(2017y / 1 / 1));
  EXPECT_EQ(ParseUtcTime("2017-01-01T05:44:60+05:45"), sys_days(2017y / 1 / 1));
  EXPECT_EQ(ParseUtcTime("1972-06-30T23:59:60Z"), sys_days(1972y / 7 / 1));
  for (const char* text : {"2015-12-31T23:59:60Z",
                           "2016-12-31T12:59:60Z",
                           "2016-12-31T23:58:60Z",
                           "2016-12-31T23:59:60+01:00",
                           "1971-12-31T23:59:60Z",
                           "2100-12-31T23:59:60Z"}) {
    EXPECT_THAT(ErrorOf(text), HasSubstr("no leap second")) << text;
  }
  EXPECT_THAT(ErrorOf("2016-12-31T23:59:61Z"), HasSubstr("second is 61"));
}

TEST(TimeTextHardCases, WritesTheEndsOfTime) {
  EXPECT_EQ(FormatUtcTime(UtcTime::min()), "1677-09-21T00:12:43.145224192Z");
  EXPECT_EQ(FormatUtcTime(UtcTime::max()), "2262-04-11T23:47:16.854775807Z");
}

TEST(TimeTextHardCases, NamesTextAndField) {
  const struct {
    const char* text;
    const char* field;
  } cases[] = {
      {"", "year"},
      {"yesterday", "year"},
      {"205-06-21T09:50:00Z", "year"},
      {"1677-06-21T09:50:00Z", "year is 1677"},
      {"2262-06-21T09:50:00Z", "year is 2262"},
      {"2005/06/21T09:50:00Z", "after the year"},
      {"2005-13-21T09:50:00Z", "month is 13"},
      {"2005-00-21T09:50:00Z", "month is 0"},
      {"2005-06-00T09:50:00Z", "day is 0"},
      {"2005-06-32T09:50:00Z", "day is 32"},
      {"2005-06-21 09:50:00Z", "after the day"},
      {"2005-06-21", "after the day"},
      {"2005-06-21T24:00:00Z", "hour is 24"},
      {"2005-06-21T9:50:00Z", "hour"},
      {"2005-06-21T-9:50:00Z", "hour"},
      {"2005-06-21T09", "after the hour"},
      {"2005-06-21T09:60:00Z", "minute is 60"},
      {"2005-06-21T09:50:0Z", "second"},
      {"2005-06-21T09:50:nanZ", "second"},
      {"2005-06-21T09:50:00.Z", "decimals"},
      {"2005-06-21T09:50:00.1234567891Z", "decimals"},
      {"2005-06-21T09:50:00", "without Z"},
      {"2005-06-21T09:50:00z", "without Z"},
      {"2005-06-21T09:50:00+24:00", "hour of the offset is 24"},
      {"2005-06-21T09:50:00+05:60", "minute of the offset is 60"},
      {"2005-06-21T09:50:00+5:45", "hour of the offset"},
      {"2005-06-21T09:50:00Z ", "goes on"},
      {"2005-06-21T09:50:00+05:45Z", "goes on"},
  };
  for (const auto& c : cases) {
    EXPECT_THAT(ErrorOf(c.text), AllOf(HasSubstr(Quoted(c.text)), HasSubstr(c.field)));
  }
}

}  // namespace
}  // namespace pleinair::time_text_hard_cases_test
