// The one front of the program: milliseconds a frame against error, as a table and as a page.
#pragma once

#include <string>
#include <vector>

#include "apps/front_trials.h"

namespace pleinair {

struct FrontPage {
  std::string title;
  std::vector<std::string> settings;  // One a line: frames, seeds, machine.
  std::vector<FrontPoint> points;     // As FrontTrials::Search gives them.
};

// A line a combination that was tried: comma-separated, medians with smallest and largest.
std::string FrontCsv(const FrontPage& page);

// A line a named quality: what it costs, and whether it is on the fronts or what beats it.
std::string QualitiesInWords(const FrontPage& page);

// Errors of picture and light against time, still and moving, with the named qualities: an SVG.
std::string FrontChart(const FrontPage& page);

// One file that needs nothing else. Charts as by ChartsForPage.
std::string FrontHtml(const FrontPage& page);

}  // namespace pleinair
