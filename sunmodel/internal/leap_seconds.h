// TAI - UTC since 1972, from ERFA's table.
#pragma once

#include <chrono>

namespace pleinair {

// The first day of UTC with whole leap seconds; before it TAI - UTC is not defined here.
inline constexpr std::chrono::sys_days kFirstLeapSecondDay =
    std::chrono::year{1972} / std::chrono::January / 1;

// Returns TAI - UTC on a day. Before kFirstLeapSecondDay, that day's; after the table's last entry,
// the last one kept.
double TaiMinusUtcS(std::chrono::sys_days day);

// Whether UTC had a second 23:59:60 just before `day` began.
bool LeapSecondEndsBefore(std::chrono::sys_days day);

}  // namespace pleinair
