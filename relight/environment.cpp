#include "relight/environment.h"
