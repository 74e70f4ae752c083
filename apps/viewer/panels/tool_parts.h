// Parts of the panel Tools, a file each.
#pragma once

#include "apps/viewer/view_model.h"

namespace pleinair {

void DrawColourTool(ViewModel& model);
void DrawResponseTool(ViewModel& model);
void DrawLensTool(ViewModel& model);

}  // namespace pleinair
