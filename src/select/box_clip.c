// SPDX-License-Identifier: MIT
#include "select/box_clip.h"

#include <assert.h>

typedef struct plane {
    stp_vec3d normal; ///< unit
    double distance;  ///< from the centre of the box
} plane;

/// Planes of a box and of sections. @return their number
static uint32_t make_planes(const stp_sections* sections, stp_vec3d center, stp_vec3d half,
                            plane planes[STP_BOX_CLIP_PLANES])
{
    const double sides[3] = {half.x, half.y, half.z};
    uint32_t count = 0;
    for (int k = 0; k < 6; ++k) {
        double sign = k < 3 ? 1.0 : -1.0;
        stp_vec3d normal = {k % 3 == 0 ? sign : 0.0, k % 3 == 1 ? sign : 0.0,
                            k % 3 == 2 ? sign : 0.0};
        planes[count++] = (plane){normal, sides[k % 3]};
    }
    for (uint32_t i = 0; i < sections->count && i < STP_SECTION_PLANES; ++i) {
        const stp_section_plane* s = &sections->planes[i];
        double length = sqrt(stp_dotd(s->normal, s->normal));
        double distance = (s->distance - stp_dotd(s->normal, center)) / length;
        if (length > 0.0 && isfinite(length) && isfinite(distance)) {
            assert(count < STP_BOX_CLIP_PLANES);
            planes[count++] = (plane){stp_scaled(s->normal, 1.0 / length), distance};
        }
    }
    return count;
}

/// Intersection of three planes. @return false if it is not a single point
static bool intersect(const plane* a, const plane* b, const plane* c, stp_vec3d* point)
{
    stp_vec3d bc = stp_crossd(b->normal, c->normal);
    double determinant = stp_dotd(a->normal, bc);
    if (fabs(determinant) < 1e-9) {
        return false;
    }
    stp_vec3d sum = stp_scaled(bc, a->distance);
    sum = stp_addd(sum, stp_scaled(stp_crossd(c->normal, a->normal), b->distance));
    sum = stp_addd(sum, stp_scaled(stp_crossd(a->normal, b->normal), c->distance));
    *point = stp_scaled(sum, 1.0 / determinant);
    return true;
}

uint32_t stp_box_clip(const stp_boxd* box, const stp_sections* sections,
                      stp_vec3d corners[STP_BOX_CLIP_CORNERS])
{
    plane planes[STP_BOX_CLIP_PLANES];
    stp_vec3d center = stp_scaled(stp_addd(box->min, box->max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    uint32_t count = make_planes(sections, center, half, planes), found = 0;
    double slack = 1e-9 * sqrt(stp_dotd(half, half));
    for (uint32_t a = 0; a < count; ++a) {
        for (uint32_t b = a + 1; b < count; ++b) {
            for (uint32_t c = b + 1; c < count; ++c) {
                stp_vec3d p;
                bool inside = intersect(&planes[a], &planes[b], &planes[c], &p);
                for (uint32_t k = 0; k < count && inside; ++k) {
                    inside = stp_dotd(planes[k].normal, p) <= planes[k].distance + slack;
                }
                if (inside) {
                    assert(found < STP_BOX_CLIP_CORNERS && "three planes meet at most once");
                    corners[found++] = p;
                }
            }
        }
    }
    return found;
}
