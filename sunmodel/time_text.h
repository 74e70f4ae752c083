// UTC as text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "scene/utc_time.h"

namespace pleinair {

// Parses ISO 8601: "2005-06-21T09:50:00.25Z", or with an offset ("+05:45", "+0545", "-07") in place
// of Z; seconds may be left out, and have up to nine decimals. Second 60 is accepted where UTC had
// one, and means the next minute's start. Years 1678 to 2261 (what UtcTime holds).
// Throws std::invalid_argument naming the text and the field.
UtcTime ParseUtcTime(std::string_view text);

// ISO 8601 with Z; as many decimals of the second as are not zero.
std::string FormatUtcTime(UtcTime time);

// Returns why light of the time `stated` is not that of a frame of `time`: they are more than an
// hour apart, which no corrected clock explains. Empty: it may be.
std::string FaultOfTime(const std::optional<UtcTime>& stated, UtcTime time);

}  // namespace pleinair
