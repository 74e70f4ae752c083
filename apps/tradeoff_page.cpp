#include "apps/tradeoff_page.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "apps/chart_page.h"
#include "apps/html_text.h"

namespace pleinair {
namespace {

// One axis, ready to be written.
struct AxisView {
  std::vector<TradeoffPoint> points;  // One a result.
  std::vector<FrontPlace> places;
};

AxisView ViewOf(const SweptAxis& swept) {
  AxisView view;
  for (const SweepResult& result : swept.results) {
    TradeoffPoint& point = view.points.emplace_back();
    for (const TrialFigures& trial : result.trials) {
      point.error.push_back(trial.error);
      point.time_ms.push_back(trial.time_ms);
    }
  }
  view.places = PlacesOnFront(view.points);
  return view;
}

// Errors of the light are shown in per cent.
double ErrorUnit(const SweepAxis& axis) { return axis.JudgesLight() ? 100.0 : 1.0; }

const char* ErrorWords(const SweepAxis& axis) {
  return axis.JudgesLight() ? "error of sun and sky, %" : "error of the picture, code values";
}

const char* TimeWords(const SweepAxis& axis) {
  switch (axis.judge) {
    case SweepAxis::Judge::kEstimate:
      return "from the samples' pixels to covariance, ms";
    case SweepAxis::Judge::kTransport:
      return "under a new sun: transport, drawing and estimate, ms";
    case SweepAxis::Judge::kPicture:
      return "frame under a new sun, without files, ms";
  }
  return "";
}

std::optional<double> MedianOf(const SweepResult& result,
                               std::optional<double> TrialFigures::*figure) {
  std::vector<double> values;
  for (const TrialFigures& trial : result.trials) {
    if (trial.*figure) values.push_back(*(trial.*figure));
  }
  const std::optional<Spread> spread = SpreadOf(values);
  return spread ? std::optional(spread->median) : std::nullopt;
}

// "500 is on the front." or what beats it.
std::string DefaultSentence(const SweptAxis& swept, const AxisView& view) {
  for (std::size_t i = 0; i < swept.results.size(); ++i) {
    const SweepResult& result = swept.results[i];
    if (!result.is_default) continue;
    if (result.trials.empty()) return "the default, " + result.value + ", could not be measured";
    const FrontPlace& place = view.places[i];
    if (place.on_front) return "the default, " + result.value + ", is on the front";
    const SweepResult& other = swept.results[*place.beaten_by];
    const Spread mine = *SpreadOf(view.points[i].error);
    const Spread its = *SpreadOf(view.points[*place.beaten_by].error);
    const double unit = ErrorUnit(swept.axis);
    const Spread my_ms = *SpreadOf(view.points[i].time_ms);
    const Spread its_ms = *SpreadOf(view.points[*place.beaten_by].time_ms);
    constexpr double kSame = 1e-3;  // Far below any spread: two ways to one answer.
    if (mine.median - its.median <= kSame * mine.median) {
      return fmt::format(
          "the default, {}, is not on the front: {} has the same error, {:.3g}, and takes {:.3g} "
          "ms against {:.3g}{}",
          result.value,
          other.value,
          unit * its.median,
          its_ms.median,
          my_ms.median,
          its_ms.largest >= my_ms.smallest ? ", no more than times scatter" : "");
    }
    return fmt::format(
        "the default, {}, is not on the front: {} has an error of {:.3g} against {:.3g} (spreads "
        "{:.3g} to {:.3g}, {:.3g} to {:.3g}; less with {} of {} seeds) and takes {:.3g} ms against "
        "{:.3g}",
        result.value,
        other.value,
        unit * its.median,
        unit * mine.median,
        unit * its.smallest,
        unit * its.largest,
        unit * mine.smallest,
        unit * mine.largest,
        place.seeds_beaten,
        place.seeds,
        its_ms.median,
        my_ms.median);
  }
  return "none of the values is the default";
}

std::string ChartOf(const SweptAxis& swept, const AxisView& view) {
  const double unit = ErrorUnit(swept.axis);
  ChartSeries front{"front", "#2060c0", ChartSeries::Style::kStairs, {}};
  ChartSeries others{"other values", "#606060", ChartSeries::Style::kPoints, {}};
  ChartSeries standard{"default", "#c03000", ChartSeries::Style::kPoints, {}, 1.5};
  for (std::size_t i = 0; i < swept.results.size(); ++i) {
    const std::optional<Spread> error = SpreadOf(view.points[i].error);
    const std::optional<Spread> time_ms = SpreadOf(view.points[i].time_ms);
    if (!error || !(time_ms->smallest > 0.0)) continue;
    ChartPoint point{InUnit(*time_ms, 1.0), InUnit(*error, unit), swept.results[i].value};
    (swept.results[i].is_default ? standard : others).points.push_back(point);
    point.label.clear();
    if (view.places[i].on_front) front.points.push_back(std::move(point));
  }
  if (standard.points.empty() && others.points.empty()) return {};
  std::sort(front.points.begin(), front.points.end(), [](const ChartPoint& a, const ChartPoint& b) {
    return a.x.value < b.x.value;
  });
  const Chart chart{"",
                    {TimeWords(swept.axis)},
                    {ErrorWords(swept.axis)},
                    {std::move(front), std::move(others), std::move(standard)}};
  return ChartsForPage(std::span(&chart, 1));
}

std::string TableOf(const SweptAxis& swept, const AxisView& view) {
  const bool light = swept.axis.JudgesLight();
  std::string html = fmt::format(
      "<table><tr><th>{}</th><th>{}</th><th>spread</th>"
      "<th>ms</th><th>spread</th>{}<th></th></tr>\n",
      swept.axis.setting,
      ErrorWords(swept.axis),
      light ? "<th>sun, %</th><th>sky, %</th>" : "<th>object, dB</th><th>around it, dB</th>");
  const double unit = ErrorUnit(swept.axis);
  const auto cell = [](const std::optional<double>& value, double scale) {
    return value ? fmt::format("{:.3g}", scale * *value) : std::string("-");
  };
  for (std::size_t i = 0; i < swept.results.size(); ++i) {
    const SweepResult& result = swept.results[i];
    const std::optional<Spread> error = SpreadOf(view.points[i].error);
    if (!error) {
      html += fmt::format("<tr><td>{}</td><td colspan=\"7\" class=\"bad\">{}</td></tr>\n",
                          EscapeHtml(result.value),
                          EscapeHtml(result.failure.empty() ? "not measured" : result.failure));
      continue;
    }
    const Spread time_ms = *SpreadOf(view.points[i].time_ms);
    html += fmt::format(
        "<tr><td{}>{}</td><td>{:.3g}</td><td>{:.3g} to {:.3g}</td><td>{:.3g}</td>"
        "<td>{:.3g} to {:.3g}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        result.is_default ? " class=\"default\"" : "",
        EscapeHtml(result.value),
        unit * error->median,
        unit * error->smallest,
        unit * error->largest,
        time_ms.median,
        time_ms.smallest,
        time_ms.largest,
        light ? cell(MedianOf(result, &TrialFigures::sun_error), 100.0)
              : cell(MedianOf(result, &TrialFigures::object_psnr_db), 1.0),
        light ? cell(MedianOf(result, &TrialFigures::sky_error), 100.0)
              : cell(MedianOf(result, &TrialFigures::effect_psnr_db), 1.0),
        view.places[i].on_front ? "front" : "");
  }
  return html + "</table>\n";
}

}  // namespace

std::string TradeoffCsv(const TradeoffPage& page) {
  struct Column {
    const char* name;
    std::optional<double> TrialFigures::*figure;
  };
  static const Column kColumns[] = {{"sun_error", &TrialFigures::sun_error},
                                    {"sky_error", &TrialFigures::sky_error},
                                    {"object_psnr_db", &TrialFigures::object_psnr_db},
                                    {"effect_psnr_db", &TrialFigures::effect_psnr_db},
                                    {"transport_ms", &TrialFigures::transport_ms},
                                    {"draw_ms", &TrialFigures::draw_ms},
                                    {"estimate_ms", &TrialFigures::estimate_ms},
                                    {"objects_ms", &TrialFigures::objects_ms},
                                    {"render_ms", &TrialFigures::render_ms}};
  std::string csv =
      "setting,value,is_default,on_front,judged_by,seeds,error,error_smallest,error_largest,"
      "time_ms,time_ms_smallest,time_ms_largest";
  for (const Column& column : kColumns) csv += std::string(",") + column.name;
  csv += ",prepare_s,failure\n";
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.5g}", *value) : std::string();
  };
  for (const SweptAxis& swept : page.axes) {
    const AxisView view = ViewOf(swept);
    for (std::size_t i = 0; i < swept.results.size(); ++i) {
      const SweepResult& result = swept.results[i];
      const std::optional<Spread> error = SpreadOf(view.points[i].error);
      const std::optional<Spread> time_ms = SpreadOf(view.points[i].time_ms);
      csv += fmt::format("{},{},{},{},{},{}",
                         swept.axis.setting,
                         CsvText(result.value),
                         result.is_default ? 1 : 0,
                         view.places[i].on_front ? 1 : 0,
                         swept.axis.JudgesLight() ? "light" : "picture",
                         result.trials.size());
      for (const std::optional<Spread>& spread : {error, time_ms}) {
        csv += spread
                   ? fmt::format(
                         ",{:.5g},{:.5g},{:.5g}", spread->median, spread->smallest, spread->largest)
                   : std::string(",,,");
      }
      for (const Column& column : kColumns) csv += "," + number(MedianOf(result, column.figure));
      csv += "," + number(result.prepare_s) + ",";
      csv += (result.failure.empty() ? std::string() : CsvText(result.failure)) + "\n";
    }
  }
  return csv;
}

std::string DefaultsText(const TradeoffPage& page) {
  std::string text;
  for (const SweptAxis& swept : page.axes) {
    text += swept.axis.setting + ": " + DefaultSentence(swept, ViewOf(swept)) + "\n";
  }
  return text;
}

std::string TradeoffHtml(const TradeoffPage& page) {
  std::string html = ChartPageHead(page.title) + "<ul>\n";
  for (const std::string& line : page.settings) html += "<li>" + EscapeHtml(line) + "</li>\n";
  html +=
      "</ul>\n<p>Points are medians over seeds, bars their smallest and largest. The blue stairs "
      "are the Pareto front: no other value has less error for no more time. The default is "
      "red.</p>\n<h2>Defaults</h2>\n<ul>\n";
  for (const SweptAxis& swept : page.axes) {
    html += fmt::format("<li><a href=\"#{0}\">{0}</a>: {1}</li>\n",
                        swept.axis.setting,
                        EscapeHtml(DefaultSentence(swept, ViewOf(swept))));
  }
  html += "</ul>\n";
  bool has_definitions = false;
  for (const SweptAxis& swept : page.axes) {
    const AxisView view = ViewOf(swept);
    html += fmt::format("<h2 id=\"{0}\">{0}</h2>\n<p>{1}.</p>\n",
                        swept.axis.setting,
                        EscapeHtml(swept.axis.Words()));
    const std::string svg = ChartOf(swept, view);
    html += (has_definitions ? WithoutDefinitions(svg) : svg) + "\n";
    has_definitions = has_definitions || !svg.empty();
    html += TableOf(swept, view);
  }
  return html + "</body></html>\n";
}

}  // namespace pleinair
