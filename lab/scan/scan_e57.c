// SPDX-License-Identifier: MIT
// E57 (ASTM E2807): for each station its points, relative to it, in packets of columns; then XML
// that describes these sections and has the poses. Misses are not stored; cells are identified by
// row and column.
#include "base/io/bytes.h"
#include "base/math/rng.h"
#include "lab/scan/scan_file.h"

#include <assert.h>
#include <stdio.h>

enum {
    PACKET_POINTS = 2048,
    COLUMNS = 9,
    SECTION_HEADER = 32,
    PACKET_HEADER = 6 + 2 * COLUMNS,
    INDEX_PACKET = 32,
    POINT = 23, ///< bytes, over all columns
};

/// Bytes of a value in each column.
static const uint8_t widths[COLUMNS] = {4, 4, 4, 4, 1, 1, 1, 2, 2};

/// Description of a station in the XML.
typedef struct stored_station {
    scan_station station;
    uint64_t section, count;
    stp_boxd bounds;
} stored_station;

struct scan_e57_state {
    e57_pages pages;
    stored_station* stations; ///< in the same allocation, after this struct
    uint32_t station_count;
    uint64_t section_page; ///< start of the section
    uint64_t data, logical;
    unsigned char columns[COLUMNS][4 * PACKET_POINTS];
    uint32_t waiting; ///< points in `columns`
    unsigned char first_page[E57_PAYLOAD];
    bool has_first_page;
};

typedef struct scan_e57_state e57;

static stp_result put(e57* s, const void* bytes, size_t size)
{
    bool first = s->pages.whole == s->section_page;
    if (first && !s->has_first_page) { // kept, because its head is not known yet
        size_t room = E57_PAYLOAD - s->pages.used, part = size < room ? size : room;
        memcpy(s->first_page + s->pages.used, bytes, part);
        s->has_first_page = part == room;
    }
    return e57_put(&s->pages, bytes, size);
}

static stp_result begin(scan_file* f)
{
    size_t size = sizeof(e57) + sizeof(stored_station) * (size_t)f->desc.stations;
    f->state = stp_alloc_zeroed(f->context, size, 1);
    if (f->state == NULL) {
        return stp_fail_memory(f->context);
    }
    e57* s = f->state;
    s->pages.writer = f->writer;
    s->stations = (stored_station*)(s + 1);
    const unsigned char empty[E57_PAYLOAD] = {0};
    return e57_put(&s->pages, empty, E57_PAYLOAD);
}

static stp_result begin_station(scan_file* f, const scan_station* station)
{
    e57* s = f->state;
    const unsigned char head[SECTION_HEADER] = {0};
    assert(s->station_count < f->desc.stations && "there is room for the stations announced");
    assert(s->pages.used == 0 && s->waiting == 0 && "a section starts a page");
    s->stations[s->station_count] = (stored_station){
        .station = *station, .section = e57_physical(&s->pages), .bounds = stp_boxd_empty()};
    s->section_page = s->pages.whole;
    s->logical = e57_logical(&s->pages);
    s->has_first_page = false;
    memset(s->first_page, 0, E57_PAYLOAD);
    stp_result result = put(s, head, sizeof(head));
    s->data = e57_physical(&s->pages);
    return result;
}

static stp_result put_packet(e57* s)
{
    static const unsigned char zeros[4] = {0};
    unsigned char head[PACKET_HEADER] = {1};
    uint32_t size = PACKET_HEADER + POINT * s->waiting, fill = (4 - size % 4) % 4;
    assert(s->waiting <= PACKET_POINTS && size + fill <= 1u << 16 && "16 bits store the length");
    stp_write_u16(head + 2, (uint16_t)(size + fill - 1));
    stp_write_u16(head + 4, COLUMNS);
    for (size_t c = 0; c < COLUMNS; ++c) {
        stp_write_u16(head + 6 + 2 * c, (uint16_t)(widths[c] * s->waiting));
    }
    stp_result result = put(s, head, sizeof(head));
    for (size_t c = 0; c < COLUMNS && result == STP_OK; ++c) {
        result = put(s, s->columns[c], (size_t)widths[c] * s->waiting);
    }
    s->waiting = 0;
    return result == STP_OK ? put(s, zeros, fill) : result;
}

static stp_result add(scan_file* f, const scan_station* station, const scan_point* points,
                      size_t count)
{
    e57* s = f->state;
    stored_station* to = &s->stations[s->station_count];
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        const scan_point* p = &points[i];
        if (!p->hit) {
            continue;
        }
        uint32_t at = s->waiting++;
        const double base[3] = {station->place.x, station->place.y, station->place.z};
        float local[3];
        for (size_t k = 0; k < 3; ++k) {
            local[k] = (float)(p->place[k] - base[k]);
            stp_write_f32(s->columns[k] + 4 * (size_t)at, local[k]);
            s->columns[4 + k][at] = p->color[k];
        }
        stp_write_f32(s->columns[3] + 4 * (size_t)at, (float)p->intensity / 65535.0f);
        stp_write_u16(s->columns[7] + 2 * (size_t)at, (uint16_t)p->row);
        stp_write_u16(s->columns[8] + 2 * (size_t)at, (uint16_t)p->column);
        stp_boxd_add(&to->bounds, stp_to_double((stp_vec3){local[0], local[1], local[2]}));
        to->count += 1;
        result = s->waiting == PACKET_POINTS ? put_packet(s) : STP_OK;
    }
    return result;
}

static stp_result end_station(scan_file* f, const scan_station* station)
{
    (void)station;
    e57* s = f->state;
    stp_result result = s->waiting > 0 ? put_packet(s) : STP_OK;
    uint64_t index = e57_physical(&s->pages);
    unsigned char packet[INDEX_PACKET] = {0}; // one entry: the first point lies where data begin
    stp_write_u16(packet + 2, INDEX_PACKET - 1);
    stp_write_u16(packet + 4, 1);
    stp_write_u64(packet + 24, s->data);
    result = result == STP_OK ? put(s, packet, sizeof(packet)) : result;
    uint64_t end = e57_logical(&s->pages);
    result = result == STP_OK ? e57_end_page(&s->pages) : result;
    s->first_page[0] = 1;
    stp_write_u64(s->first_page + 8, end - s->logical);
    stp_write_u64(s->first_page + 16, s->data);
    stp_write_u64(s->first_page + 24, index);
    s->station_count += 1;
    return result == STP_OK ? e57_replace_page(&s->pages, s->section_page, s->first_page) : result;
}

static stp_result put_station_xml(e57* s, const double shift[3], uint32_t index)
{
    const stored_station* at = &s->stations[index];
    const stp_boxd none = {0}, b = at->count > 0 ? at->bounds : none;
    uint64_t id = stp_rng_hash(at->count, at->station.number);
    char text[4096];
    int size = snprintf(
        text, sizeof(text),
        "<vectorChild type=\"Structure\"><guid type=\"String\">{%016llX}</guid>\n"
        "<name type=\"String\">station %u</name>\n"
        "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">1</w>"
        "<x type=\"Float\">0</x><y type=\"Float\">0</y><z type=\"Float\">0</z></rotation>"
        "<translation type=\"Structure\"><x type=\"Float\">%.17g</x><y type=\"Float\">%.17g</y>"
        "<z type=\"Float\">%.17g</z></translation></pose>\n"
        "<cartesianBounds type=\"Structure\"><xMinimum type=\"Float\">%.17g</xMinimum>"
        "<xMaximum type=\"Float\">%.17g</xMaximum><yMinimum type=\"Float\">%.17g</yMinimum>"
        "<yMaximum type=\"Float\">%.17g</yMaximum><zMinimum type=\"Float\">%.17g</zMinimum>"
        "<zMaximum type=\"Float\">%.17g</zMaximum></cartesianBounds>\n"
        "<intensityLimits type=\"Structure\"><intensityMinimum type=\"Float\">0</intensityMinimum>"
        "<intensityMaximum type=\"Float\">1</intensityMaximum></intensityLimits>\n"
        "<colorLimits type=\"Structure\"><colorRedMinimum type=\"Integer\">0</colorRedMinimum>"
        "<colorRedMaximum type=\"Integer\">255</colorRedMaximum>"
        "<colorGreenMinimum type=\"Integer\">0</colorGreenMinimum>"
        "<colorGreenMaximum type=\"Integer\">255</colorGreenMaximum>"
        "<colorBlueMinimum type=\"Integer\">0</colorBlueMinimum>"
        "<colorBlueMaximum type=\"Integer\">255</colorBlueMaximum></colorLimits>\n"
        "<indexBounds type=\"Structure\"><rowMinimum type=\"Integer\">0</rowMinimum>"
        "<rowMaximum type=\"Integer\">%u</rowMaximum><columnMinimum type=\"Integer\">0"
        "</columnMinimum><columnMaximum type=\"Integer\">%u</columnMaximum></indexBounds>\n"
        "<points type=\"CompressedVector\" fileOffset=\"%llu\" recordCount=\"%llu\">",
        (unsigned long long)id, at->station.number, at->station.place.x + shift[0],
        at->station.place.y + shift[1], at->station.place.z + shift[2], b.min.x, b.max.x, b.min.y,
        b.max.y, b.min.z, b.max.z, at->station.rows - 1, at->station.columns - 1,
        (unsigned long long)at->section, (unsigned long long)at->count);
    static const char prototype[] =
        "<prototype type=\"Structure\">"
        "<cartesianX type=\"Float\" precision=\"single\">0</cartesianX>"
        "<cartesianY type=\"Float\" precision=\"single\">0</cartesianY>"
        "<cartesianZ type=\"Float\" precision=\"single\">0</cartesianZ>"
        "<intensity type=\"Float\" precision=\"single\" minimum=\"0\" maximum=\"1\">0</intensity>"
        "<colorRed type=\"Integer\" minimum=\"0\" maximum=\"255\">0</colorRed>"
        "<colorGreen type=\"Integer\" minimum=\"0\" maximum=\"255\">0</colorGreen>"
        "<colorBlue type=\"Integer\" minimum=\"0\" maximum=\"255\">0</colorBlue>"
        "<rowIndex type=\"Integer\" minimum=\"0\" maximum=\"65535\">0</rowIndex>"
        "<columnIndex type=\"Integer\" minimum=\"0\" maximum=\"65535\">0</columnIndex></prototype>"
        "<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\"></codecs></points>"
        "</vectorChild>\n";
    assert(size > 0 && (size_t)size < sizeof(text) && "the description is not cut off");
    stp_result result = e57_put(&s->pages, text, (size_t)size);
    return result == STP_OK ? e57_put(&s->pages, prototype, sizeof(prototype) - 1) : result;
}

static stp_result end(scan_file* f)
{
    e57* s = f->state;
    uint64_t xml = e57_physical(&s->pages), logical = e57_logical(&s->pages);
    char text[1024];
    int size = snprintf(
        text, sizeof(text),
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<e57Root type=\"Structure\" xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n"
        "<formatName type=\"String\">ASTM E57 3D Imaging Data File</formatName>\n"
        "<guid type=\"String\">{%016llX}</guid>\n"
        "<versionMajor type=\"Integer\">1</versionMajor>\n"
        "<versionMinor type=\"Integer\">0</versionMinor>\n"
        "<e57LibraryVersion type=\"String\">Stipple " STP_VERSION "</e57LibraryVersion>\n"
        "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n",
        (unsigned long long)stp_rng_hash(f->points, f->misses));
    stp_result result = e57_put(&s->pages, text, (size_t)size);
    for (uint32_t i = 0; i < s->station_count && result == STP_OK; ++i) {
        result = put_station_xml(s, f->desc.shift, i);
    }
    static const char tail[] = "</data3D>\n<images2D type=\"Vector\" "
                               "allowHeterogeneousChildren=\"1\"></images2D>\n</e57Root>\n";
    result = result == STP_OK ? e57_put(&s->pages, tail, sizeof(tail) - 1) : result;
    uint64_t length = e57_logical(&s->pages) - logical;
    result = result == STP_OK ? e57_end_page(&s->pages) : result;
    unsigned char head[E57_PAYLOAD] = {0};
    memcpy(head, "ASTM-E57", 8);
    stp_write_u32(head + 8, 1);
    stp_write_u64(head + 16, s->pages.whole * E57_PAGE);
    stp_write_u64(head + 24, xml);
    stp_write_u64(head + 32, length);
    stp_write_u64(head + 40, E57_PAGE);
    return result == STP_OK ? e57_replace_page(&s->pages, 0, head) : result;
}

const scan_format scan_format_e57 = {.ending = ".e57",
                                     .begin = begin,
                                     .begin_station = begin_station,
                                     .add = add,
                                     .end_station = end_station,
                                     .end = end};
