// SPDX-License-Identifier: MIT
#include "select/sections.h"

#include <assert.h>

#define WIDER 1e-6 // outward shift of a box's planes, relative to its diagonal

bool stp_sections_are_valid(const stp_sections* sections)
{
    if (sections->count > STP_SECTION_PLANES) {
        return false;
    }
    for (uint32_t i = 0; i < sections->count; ++i) {
        const stp_section_plane* plane = &sections->planes[i];
        double square = stp_dotd(plane->normal, plane->normal);
        if (!(square > 0.0) || !isfinite(square) || !isfinite(plane->distance)) {
            return false;
        }
    }
    return true;
}

bool stp_sections_add_plane(stp_sections* sections, stp_vec3d point, stp_vec3d normal)
{
    if (sections->count >= STP_SECTION_PLANES) {
        return false;
    }
    normal = stp_normalized(normal);
    stp_section_plane* plane = &sections->planes[sections->count++];
    *plane = (stp_section_plane){.normal = normal, .distance = stp_dotd(normal, point)};
    if (!stp_sections_are_valid(sections)) {
        sections->count -= 1;
        return false;
    }
    return true;
}

double stp_sections_box_margin(const stp_boxd* box, double rounding)
{
    stp_vec3d size = stp_subd(box->max, box->min);
    return WIDER * sqrt(stp_dotd(size, size)) + rounding;
}

bool stp_sections_add_box(stp_sections* sections, const stp_boxd* box, double rounding)
{
    static const stp_vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    uint32_t before = sections->count;
    bool added = !stp_boxd_is_empty(*box);
    double wider = stp_sections_box_margin(box, rounding);
    stp_vec3d margin = {wider, wider, wider};
    for (int k = 0; k < 3; ++k) {
        added =
            added && stp_sections_add_plane(sections, stp_addd(box->max, margin), axes[k]) &&
            stp_sections_add_plane(sections, stp_subd(box->min, margin), stp_scaled(axes[k], -1.0));
    }
    assert(!added || sections->count == before + 6);
    sections->count = added ? sections->count : before;
    return added;
}

void stp_sections_drop_idle(stp_sections* sections, const stp_boxd* box, double rounding)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < sections->count; ++i) {
        const stp_section_plane plane = sections->planes[i];
        stp_vec3d n = plane.normal;
        stp_vec3d farthest = {n.x > 0.0 ? box->max.x : box->min.x,
                              n.y > 0.0 ? box->max.y : box->min.y,
                              n.z > 0.0 ? box->max.z : box->min.z};
        double beyond = rounding * (fabs(n.x) + fabs(n.y) + fabs(n.z));
        if (stp_section_beyond(&plane, farthest) + beyond > 0.0) {
            sections->planes[kept++] = plane;
        }
    }
    sections->count = kept;
}

bool stp_sections_exclude(const stp_sections* sections, stp_vec3d point)
{
    for (uint32_t i = 0; i < sections->count; ++i) {
        if (stp_section_beyond(&sections->planes[i], point) > 0.0) {
            return true;
        }
    }
    return false;
}

bool stp_sections_test(const stp_sections* sections, const stp_boxd* box, double margin,
                       uint32_t* mask)
{
    assert(sections->count <= STP_SECTION_PLANES);
    assert((*mask & ~stp_sections_all(sections)) == 0 && "bits of existing planes");
    assert(!(margin < 0.0));
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    stp_vec3d center = stp_addd(box->min, half);
    for (uint32_t bits = *mask; bits != 0; bits &= bits - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(bits);
        const stp_section_plane* plane = &sections->planes[i];
        double x = fabs(plane->normal.x), y = fabs(plane->normal.y), z = fabs(plane->normal.z);
        double reach = x * half.x + y * half.y + z * half.z + margin * (x + y + z);
        double middle = stp_section_beyond(plane, center);
        reach += 1e-12 * (x * fabs(center.x) + y * fabs(center.y) + z * fabs(center.z));
        if (middle > reach) {
            return false;
        }
        if (middle < -reach) {
            *mask &= ~(1u << i);
        }
    }
    return true;
}

void stp_section_row(const stp_section_plane* plane, const stp_affine* transform,
                     const float offset[3], double row[4])
{
    stp_vec3d n = plane->normal;
    stp_vec3d base = stp_affine_point(
        transform, (stp_vec3d){(double)offset[0], (double)offset[1], (double)offset[2]});
    for (int c = 0; c < 3; ++c) {
        row[c] = n.x * transform->m[0][c] + n.y * transform->m[1][c] + n.z * transform->m[2][c];
    }
    row[3] = stp_section_beyond(plane, base);
}
