// Imperfections of a recording and their sizes, for `tradeoff --sweep imperfections`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datasets/degradation.h"

namespace pleinair {

struct ImperfectionDial {
  std::string name;   // In tables.
  std::string label;  // In charts: "north".
  std::string words;  // "north is off by"
  std::string unit;   // "°"; empty: a plain number.
  // Five, from the slightest on: about what a careful survey leaves, what a phone at a place that
  // was measured with a tape does, what a guess does, and beyond.
  std::vector<double> sizes;
  double usual = 0.0;  // Among the sizes: a phone's, or a guess where a phone has none.
  std::function<void(Imperfections&, double)> set;
  // Has a meaning only where the survey has no map: compared with a recording that lacks it, too.
  bool without_map = false;
};

std::vector<ImperfectionDial> ImperfectionDials();

}  // namespace pleinair
