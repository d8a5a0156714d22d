// SPDX-License-Identifier: MIT
#include "import/reading/place_sample.h"

#include <math.h>
#include <stdlib.h>

void stp_place_sample_add(stp_place_sample* sample, const double place[3])
{
    if (sample->count < STP_PLACE_SAMPLES && isfinite(place[0]) && isfinite(place[1]) &&
        isfinite(place[2])) {
        for (int k = 0; k < 3; ++k) {
            sample->places[k][sample->count] = place[k];
        }
        sample->count += 1;
    }
}

static int compare_doubles(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return x < y ? -1 : x > y;
}

void stp_place_sample_choose(stp_place_sample* sample, double place[3])
{
    for (int k = 0; k < 3; ++k) {
        double first = sample->count > 0 ? sample->places[k][0] : 0.0;
        qsort(sample->places[k], sample->count, sizeof(double), compare_doubles);
        double middle = sample->count > 0 ? sample->places[k][sample->count / 2] : 0.0;
        place[k] = fabs(first - middle) < STP_PLACE_NEAR ? first : middle;
    }
}
