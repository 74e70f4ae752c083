#include "relight/patch_scene.h"
