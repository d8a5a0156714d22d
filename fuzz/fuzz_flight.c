// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_flight -max_total_time=60 -max_len=4096 build/corpus/fuzz_flight
// Seeds: lab/scenes/flights/*.json
//
// Arbitrary bytes as a flight: a failure is logged once; an accepted flight gives finite views at
// any time and passes through its keys.
#include "fuzz.h"

#include "base/math/math.h"
#include "program/present/flight.h"

static bool is_finite(stp_vec3d v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void check_flight(const stp_flight* flight)
{
    require(flight->key_count > 0 && stp_flight_frame_count(flight, flight->fps) >= 1);
    for (size_t i = 0; i < flight->key_count; ++i) {
        const stp_flight_key* key = &flight->keys[i];
        stp_view view = {0};
        stp_flight_get_view(flight, key->t, &view);
        require(view.eye.x >= key->eye.x && view.eye.x <= key->eye.x);
        require(view.target.z >= key->target.z && view.target.z <= key->target.z);
        double next = i + 1 < flight->key_count ? key[1].t : key->t + 1.0;
        for (int k = 1; k < 4; ++k) {
            stp_flight_get_view(flight, key->t + 0.25 * k * (next - key->t), &view);
            require(is_finite(view.eye) && is_finite(view.target));
            require(fabs(stp_dotd(view.up, view.up) - 1.0) < 1e-9);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    int errors = 0;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return 0;
    }
    stp_flight flight;
    stp_result result = stp_flight_parse(context, "fuzz.json", data, size, &flight);
    require(errors == (result != STP_OK));
    if (result == STP_OK) {
        check_flight(&flight);
        stp_flight_destroy(context, &flight);
    }
    stp_context_destroy(context);
    return 0;
}
