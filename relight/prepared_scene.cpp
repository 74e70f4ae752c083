#include "relight/prepared_scene.h"
