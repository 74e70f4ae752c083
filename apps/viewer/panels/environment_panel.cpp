#include <algorithm>

#include <imgui.h>

#include "apps/viewer/panel.h"

namespace pleinair {

void DrawEnvironmentPanel(ViewModel& model) {
  if (model.frame && model.frame->environment && model.environment_number != model.frame->number) {
    model.environment.Upload(*model.frame->environment);
    model.environment_number = model.frame->number;
  }
  if (model.environment.Width() == 0) {
    ImGui::TextDisabled("no frame yet");
    return;
  }
  const float width = ImGui::GetContentRegionAvail().x;
  const float height = width * static_cast<float>(model.environment.Height()) /
                       static_cast<float>(model.environment.Width());
  ImGui::Image(model.environment.Id(), {width, height});
  ImGui::PushTextWrapPos();
  ImGui::TextDisabled("real light around the objects: centre north, right east, top zenith");
  ImGui::PopTextWrapPos();
  ImGui::Checkbox("white balls: the probes, or one in this light", &model.request.wants_probes);
}

}  // namespace pleinair
