#include "apps/camera_stand_in/fault_list.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace pleinair::stand_in {
namespace {

constexpr std::array<std::pair<std::string_view, FaultKind>, 14> kFaults{{
    {"unplug", FaultKind::kUnplug},
    {"unplug-renumber", FaultKind::kUnplugRenumber},
    {"stall", FaultKind::kStall},
    {"stall-forever", FaultKind::kStallForever},
    {"format-change", FaultKind::kFormatChange},
    {"truncate", FaultKind::kTruncate},
    {"corrupt", FaultKind::kCorrupt},
    {"time-repeat", FaultKind::kTimeRepeat},
    {"time-back", FaultKind::kTimeBack},
    {"clock-back", FaultKind::kClockBack},
    {"clock-forward", FaultKind::kClockForward},
    {"drop", FaultKind::kDrop},
    {"control-refused", FaultKind::kControlRefused},
    {"control-clamped", FaultKind::kControlClamped},
}};
constexpr std::string_view kRandom = "random:";
constexpr double kMostSeconds = 1e7;
constexpr std::int64_t kMostPictures = 1'000'000'000;

[[noreturn]] void Refuse(const std::string& part, const std::string& expected) {
  throw std::invalid_argument("--fault " + part + ": expected " + expected);
}

template <typename Number>
bool Parse(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

// `fields` is SEED:COUNT.
void AddRandom(const std::string& part,
               std::string_view fields,
               double end,
               std::vector<Fault>& faults) {
  const std::size_t colon = fields.find(':');
  std::uint64_t seed = 0;
  int count = 0;
  if (colon == std::string_view::npos || !Parse(fields.substr(0, colon), seed) ||
      !Parse(fields.substr(colon + 1), count) || count < 1 || count > kMaxFaults) {
    Refuse(part, "random:SEED:COUNT, with a COUNT of 1 to " + std::to_string(kMaxFaults));
  }
  std::mt19937_64 random(seed);  // Its numbers are the same everywhere; distributions' are not.
  for (int i = 0; i < count; ++i) {
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    FaultKind kind = FaultKind::kStallForever;
    while (kind == FaultKind::kStallForever) kind = kFaults[random() % kFaults.size()].second;
    faults.push_back({kind, static_cast<std::int64_t>(share * end)});
  }
}

// The moment after '@': nanoseconds, or a number of pictures.
double At(const std::string& part, bool counts_pictures) {
  const std::size_t at = part.find('@');
  std::string_view when;
  if (at != std::string::npos) when = std::string_view(part).substr(at + 1);
  if (counts_pictures) when.remove_suffix(1);
  std::int64_t pictures = 0;
  if (counts_pictures && Parse(when, pictures) && pictures >= 0 && pictures <= kMostPictures) {
    return static_cast<double>(pictures);
  }
  double seconds = 0.0;
  if (!counts_pictures && Parse(when, seconds) && seconds >= 0.0 && seconds <= kMostSeconds) {
    return seconds * kSecondNs;
  }
  Refuse(part,
         "NAME@SECONDS, with SECONDS from 0 to 10000000, or NAME@Np, with N from 0 to 1000000000");
}

}  // namespace

std::string FaultNames() {
  std::string names;
  for (const auto& [name, kind] : kFaults) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

FaultList ParseFaults(const std::string& text) {
  FaultList list;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t at = part.find('@');
    const std::string_view name = std::string_view(part).substr(0, at);
    const bool counts_pictures = at != std::string::npos && part.ends_with('p');
    const double when = At(part, counts_pictures);
    if (!list.faults.empty() && counts_pictures != list.count_pictures) {
      Refuse(part, "all of a list after pictures, or all after seconds");
    }
    list.count_pictures = counts_pictures;
    if (name.starts_with(kRandom)) {
      AddRandom(part, name.substr(kRandom.size()), when, list.faults);
      continue;
    }
    const auto* const found = std::find_if(
        kFaults.begin(), kFaults.end(), [&](const auto& entry) { return entry.first == name; });
    if (found == kFaults.end()) Refuse(part, "one of " + FaultNames() + ", random:SEED:COUNT");
    list.faults.push_back({found->second, std::llround(when)});
  }
  if (list.faults.size() > kMaxFaults) {
    Refuse("", "at most " + std::to_string(kMaxFaults) + " faults");
  }
  std::stable_sort(list.faults.begin(), list.faults.end(), [](const Fault& a, const Fault& b) {
    return a.at < b.at;
  });
  return list;
}

}  // namespace pleinair::stand_in
