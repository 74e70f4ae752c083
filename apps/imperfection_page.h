// What imperfections of recordings cost, as a table, as charts and in words.
#pragma once

#include <string>
#include <vector>

#include "apps/imperfection_trials.h"

namespace pleinair {

struct ImperfectionPage {
  std::vector<std::string> settings;  // One a line: frames, seeds, version.
  std::vector<ImperfectionDial> dials;
  std::vector<ImperfectRecording> recordings;
};

// A line a recording, dial and size, 0 included: comma-separated, medians over seeds with smallest
// and largest.
std::string ImperfectionCsv(const ImperfectionPage& page);

// A line a dial: what its usual size costs, median over recordings and seeds; the costliest first.
std::string ImperfectionsInWords(const ImperfectionPage& page);

// What each dial's usual size adds to the errors of light and picture, as an SVG file.
std::string ImperfectionOverview(const ImperfectionPage& page);

// The words, the overview (as imperfections.svg beside it) and a table of all dials and sizes,
// medians over recordings and seeds.
std::string ImperfectionMarkdown(const ImperfectionPage& page);

// One file that needs nothing else: the words, the overview, and for each dial both errors against
// its size, with the spread over seeds, and a table. Charts as by ChartsForPage.
std::string ImperfectionHtml(const ImperfectionPage& page);

}  // namespace pleinair
