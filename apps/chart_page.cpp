#include "apps/chart_page.h"

#include <fmt/format.h>

#include "apps/html_text.h"

namespace pleinair {
namespace {

constexpr const char* kChartPageStyle = R"css(
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 900px; padding: 0 1em; color: #222 }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse; font-size: .9em; display: block; overflow-x: auto }
td, th { padding: .1em .7em; text-align: right; border-bottom: 1px solid #ddd }
td:first-child, th:first-child { text-align: left } .default { color: #c03000; font-weight: bold }
svg { max-width: 100%; height: auto } .bad { color: #a00 }
)css";

}  // namespace

std::string ChartPageHead(const std::string& title) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>{0}</title>"
      "<style>{1}</style></head>\n<body><h1>{0}</h1>\n",
      EscapeHtml(title),
      kChartPageStyle);
}

ChartValue InUnit(const Spread& spread, double unit) {
  return {unit * spread.median, unit * spread.smallest, unit * spread.largest};
}

std::string CsvText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string WithoutDefinitions(const std::string& svg) {
  const std::size_t begin = svg.find("<defs>");
  const std::size_t end = svg.find("</defs>");
  if (begin == std::string::npos || end == std::string::npos) return svg;
  return svg.substr(0, begin) + svg.substr(end + 7);
}

}  // namespace pleinair
