// Functions that pages of charts and tables share.
#pragma once

#include <string>

#include "apps/svg_chart.h"
#include "pipeline/tradeoff.h"

namespace pleinair {

// Beginning of an HTML page, up to its heading; readable on a phone. End with "</body></html>".
std::string ChartPageHead(const std::string& title);

// The median with the smallest and the largest as its bar, times `unit`.
ChartValue InUnit(const Spread& spread, double unit);

// `text` as a cell of comma-separated values.
std::string CsvText(const std::string& text);

// An <svg> without the marks that gnuplot defines in the same way in each: for all but a page's
// first.
std::string WithoutDefinitions(const std::string& svg);

}  // namespace pleinair
