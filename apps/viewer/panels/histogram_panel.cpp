#include <algorithm>

#include <imgui.h>

#include "apps/viewer/panel.h"

namespace pleinair {

void DrawHistogramPanel(ViewModel& model) {
  if (!model.frame || !model.frame->histogram) {
    ImGui::TextDisabled("no picture yet");
    return;
  }
  const PictureHistogram& histogram = *model.frame->histogram;
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 size{
      ImGui::GetContentRegionAvail().x,
      std::max(60.0f,
               ImGui::GetContentRegionAvail().y - 2.0f * ImGui::GetTextLineHeightWithSpacing())};
  ImGui::Dummy(size);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(origin, {origin.x + size.x, origin.y + size.y}, IM_COL32(20, 20, 24, 255));
  constexpr ImU32 kColours[3] = {
      IM_COL32(235, 60, 60, 255), IM_COL32(70, 210, 70, 255), IM_COL32(80, 130, 255, 255)};
  const float step = size.x / 256.0f;
  const auto top = static_cast<float>(std::max(1, histogram.largest));
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t code = 1; code < 256; ++code) {
      const auto y = [&](std::size_t at) {
        const float share = std::min(1.0f, static_cast<float>(histogram.counts[at][c]) / top);
        return origin.y + size.y * (1.0f - share);
      };
      list.AddLine({origin.x + step * static_cast<float>(code - 1), y(code - 1)},
                   {origin.x + step * static_cast<float>(code), y(code)},
                   kColours[c]);
    }
  }
  const auto share = [&](std::size_t code, std::size_t c) {
    return 100.0 * histogram.counts[code][c] / std::max(1, histogram.pixels);
  };
  ImGui::Text(
      "at white: R %.2f %%, G %.2f %%, B %.2f %%", share(255, 0), share(255, 1), share(255, 2));
  ImGui::Text("at black: R %.2f %%, G %.2f %%, B %.2f %%", share(0, 0), share(0, 1), share(0, 2));
}

}  // namespace pleinair
