// Processes, perhaps on several machines, that share one job.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace pleinair {

// All ranks make the same calls in the same order, each from one thread.
class RankGroup {
 public:
  virtual ~RankGroup() = default;
  virtual std::size_t Rank() const = 0;
  virtual std::size_t Count() const = 0;
  // The ranks' bytes, one after the other; the same on all.
  virtual std::vector<std::byte> Join(std::span<const std::byte> mine) = 0;
};

struct RankShare {
  std::size_t first = 0;
  std::size_t last = 0;
};

// The rank's part of [0, count), cut at multiples of `step` alone. A null group is one rank.
inline RankShare ShareOf(const RankGroup* ranks, std::size_t count, std::size_t step) {
  if (ranks == nullptr) return {0, count};
  const std::size_t steps = (count + step - 1) / step;
  const auto cut = [&](std::size_t rank) {
    return std::min(count, steps * rank / ranks->Count() * step);
  };
  return {cut(ranks->Rank()), cut(ranks->Rank() + 1)};
}

// The ranks' values, one after the other.
template <class Value>
std::vector<Value> JoinValues(RankGroup* ranks, std::vector<Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  if (ranks == nullptr) return mine;
  const std::vector<std::byte> bytes = ranks->Join(std::as_bytes(std::span(mine)));
  std::vector<Value> all(bytes.size() / sizeof(Value));
  std::memcpy(all.data(), bytes.data(), all.size() * sizeof(Value));
  return all;
}

}  // namespace pleinair
