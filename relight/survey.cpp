#include "relight/survey.h"
