#include "sunmodel/time_text.h"

#include <array>
#include <cstdio>
#include <stdexcept>

#include "sunmodel/internal/day_split.h"
#include "sunmodel/internal/leap_seconds.h"

namespace pleinair {
namespace {

using std::chrono::nanoseconds;
using std::chrono::sys_days;

constexpr int kFirstYear = 1678;
constexpr int kLastYear = 2261;
constexpr int kMaxDecimals = 9;

// Reads the text from left to right; every refusal names the entire text.
class TimeReader {
 public:
  explicit TimeReader(std::string_view text) : text_(text), rest_(text) {}

  [[noreturn]] void Refuse(const std::string& what) const {
    throw std::invalid_argument("time '" + std::string(text_) + "': " + what);
  }

  bool Done() const { return rest_.empty(); }

  bool Take(char wanted) {
    if (rest_.empty() || rest_.front() != wanted) return false;
    rest_.remove_prefix(1);
    return true;
  }

  void Expect(char wanted, const char* where) {
    if (!Take(wanted)) {
      Refuse(std::string("expected '") + wanted + "' " + where + ", as in 2005-06-21T09:50:00Z");
    }
  }

  // Exactly `digits` decimal digits with a value in [least, most].
  int Number(int digits, int least, int most, const char* name) {
    int value = 0;
    for (int i = 0; i < digits; ++i) {
      if (!DigitNext()) {
        Refuse(std::string(name) + " is not " + std::to_string(digits) +
               " digits, as in 2005-06-21T09:50:00Z");
      }
      value = 10 * value + TakeDigit();
    }
    if (value < least || value > most) {
      Refuse(std::string(name) + " is " + std::to_string(value) + ", expected " +
             std::to_string(least) + " to " + std::to_string(most));
    }
    return value;
  }

  nanoseconds DecimalsOfSecond() {
    std::int64_t ticks = 0;
    int count = 0;
    for (; DigitNext(); ++count) {
      const int digit = TakeDigit();
      if (count < kMaxDecimals) ticks = 10 * ticks + digit;
    }
    if (count == 0 || count > kMaxDecimals) {
      Refuse("second has " + std::to_string(count) + " decimals after its point, expected 1 to 9");
    }
    for (; count < kMaxDecimals; ++count) ticks *= 10;
    return nanoseconds(ticks);
  }

  bool DigitNext() const { return !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9'; }

 private:
  int TakeDigit() {
    const int digit = rest_.front() - '0';
    rest_.remove_prefix(1);
    return digit;
  }

  std::string_view text_;
  std::string_view rest_;
};

// East of Greenwich positive: local time = UTC + offset.
std::chrono::minutes ReadOffset(TimeReader& reader) {
  if (reader.Take('Z')) return std::chrono::minutes{0};
  const bool west = reader.Take('-');
  if (!west && !reader.Take('+')) reader.Refuse("ends without Z or an offset such as +05:45");
  const int hours = reader.Number(2, 0, 23, "hour of the offset");
  int minutes = 0;
  if (reader.Take(':') || reader.DigitNext()) {
    minutes = reader.Number(2, 0, 59, "minute of the offset");
  }
  const std::chrono::minutes offset{60 * hours + minutes};
  return west ? -offset : offset;
}

}  // namespace

UtcTime ParseUtcTime(std::string_view text) {
  TimeReader reader(text);
  const int year = reader.Number(4, kFirstYear, kLastYear, "year");
  reader.Expect('-', "after the year");
  const auto month = static_cast<unsigned>(reader.Number(2, 1, 12, "month"));
  reader.Expect('-', "after the month");
  const int day = reader.Number(2, 1, 31, "day");
  const std::chrono::year_month_day date{
      std::chrono::year{year}, std::chrono::month{month}, std::chrono::day(unsigned(day))};
  if (!date.ok()) reader.Refuse("day is " + std::to_string(day) + ", which that month has not");
  reader.Expect('T', "after the day");
  const int hour = reader.Number(2, 0, 23, "hour");
  reader.Expect(':', "after the hour");
  const int minute = reader.Number(2, 0, 59, "minute");
  int second = 0;
  nanoseconds decimals{0};
  if (reader.Take(':')) {
    second = reader.Number(2, 0, 60, "second");
    if (reader.Take('.')) decimals = reader.DecimalsOfSecond();
  }
  const std::chrono::minutes offset = ReadOffset(reader);
  if (!reader.Done()) reader.Refuse("goes on after its offset or Z");

  const UtcTime minute_start =
      sys_days(date) + std::chrono::hours{hour} + std::chrono::minutes{minute} - offset;
  if (second < 60) return minute_start + std::chrono::seconds{second} + decimals;
  const UtcTime next_minute = minute_start + std::chrono::minutes{1};
  const sys_days next_day = std::chrono::floor<std::chrono::days>(next_minute);
  if (next_minute != next_day || !LeapSecondEndsBefore(next_day)) {
    reader.Refuse("second is 60, and UTC had no leap second then");
  }
  return next_minute;  // All of the leap second: UtcTime has no tick of its own for it.
}

std::string FormatUtcTime(UtcTime time) {
  const auto [day, passed] = SplitAtMidnight(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(passed);
  std::array<char, 48> buffer{};
  std::snprintf(buffer.data(),
                buffer.size(),
                "%04d-%02u-%02uT%02d:%02d:%02d.%09lld",
                int(date.year()),
                unsigned(date.month()),
                unsigned(date.day()),
                int(clock.hours().count()),
                int(clock.minutes().count()),
                int(clock.seconds().count()),
                static_cast<long long>(clock.subseconds().count()));
  std::string text(buffer.data());
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + 'Z';
}

std::string FaultOfTime(const std::optional<UtcTime>& stated, UtcTime time) {
  if (!stated || std::chrono::abs(time - *stated) <= std::chrono::hours(1)) return {};
  return "expected light of " + FormatUtcTime(time) + ", found light of " + FormatUtcTime(*stated);
}

}  // namespace pleinair
