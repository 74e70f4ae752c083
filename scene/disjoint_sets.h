// Disjoint sets of items 0, 1, ...: each item names another one of its set, or itself, as its
// parent. Two sets are joined by making the root of one the parent of the other's.
#pragma once

#include <cstdint>
#include <vector>

namespace pleinair {

// Returns the item that stands for the set of `item`; shortens the way to it.
inline std::uint32_t RootOf(std::vector<std::uint32_t>& parent, std::uint32_t item) {
  while (parent[item] != item) {
    parent[item] = parent[parent[item]];
    item = parent[item];
  }
  return item;
}

}  // namespace pleinair
