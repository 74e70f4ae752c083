#include "apps/viewer/panel.h"

#include <array>

namespace pleinair {
namespace {

constexpr std::array kPanels = {
    PanelDefinition{"Light", "Sun and sky over time, with their uncertainty", true, DrawLightPanel},
    PanelDefinition{"Objects", "What is put into the picture", true, DrawObjectsPanel},
    PanelDefinition{"Effects", "What is simulated, with bounds and times", true, DrawEffectsPanel},
    PanelDefinition{"Timing", "Where the time goes", false, DrawTimingPanel},
    PanelDefinition{
        "Histogram", "The camera's code values, and clipping", false, DrawHistogramPanel},
    PanelDefinition{"Environment", "The relit environment map", false, DrawEnvironmentPanel},
    PanelDefinition{"Events", "What happened, and what was assumed", false, DrawEventsPanel},
    PanelDefinition{"Settings", "Exposure, and every setting of a run", false, DrawSettingsPanel},
    PanelDefinition{"Tools",
                    "Objects, the mask of samples, the camera's pose, colours and response",
                    false,
                    DrawToolsPanel},
    PanelDefinition{
        "Daylight", "Windows, and samples of the sky through them", false, DrawDaylightPanel},
};

}  // namespace

std::span<const PanelDefinition> Panels() { return kPanels; }

}  // namespace pleinair
