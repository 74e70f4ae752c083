// What `pleinair tradeoff` found, as a table and as a page.
#pragma once

#include <string>
#include <vector>

#include "apps/tradeoff_trials.h"

namespace pleinair {

struct TradeoffPage {
  std::string title;
  std::vector<std::string> settings;  // One a line: frames, seeds, machine.
  std::vector<SweptAxis> axes;
};

// A line a setting: comma-separated values, medians over seeds, with smallest and largest.
std::string TradeoffCsv(const TradeoffPage& page);

// One file that needs nothing else: for each axis a chart with the Pareto front, the default and
// the spread, a table, and a sentence on the default. Charts as by ChartsForPage.
std::string TradeoffHtml(const TradeoffPage& page);

// Whether each axis's default is on its front, one line each, to print.
std::string DefaultsText(const TradeoffPage& page);

}  // namespace pleinair
