// Small windows over the picture.
#pragma once

#include <span>

#include "apps/viewer/view_model.h"

namespace pleinair {

struct PanelDefinition {
  const char* name;
  const char* help;  // In a line.
  bool is_open_at_first;
  void (*draw)(ViewModel& model);  // Inside of its window.
};

// In the order of their keys, F2 to F9 and F11; those that follow have none.
std::span<const PanelDefinition> Panels();

// panels/, a file each.
void DrawLightPanel(ViewModel& model);
void DrawObjectsPanel(ViewModel& model);
void DrawEffectsPanel(ViewModel& model);
void DrawTimingPanel(ViewModel& model);
void DrawHistogramPanel(ViewModel& model);
void DrawEnvironmentPanel(ViewModel& model);
void DrawDaylightPanel(ViewModel& model);
void DrawEventsPanel(ViewModel& model);
void DrawSettingsPanel(ViewModel& model);
void DrawToolsPanel(ViewModel& model);

}  // namespace pleinair
