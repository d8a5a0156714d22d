// SPDX-License-Identifier: MIT
// Drawing: graphs in panels, and shapes over the picture.
#include "program/viewer/window/gui.h"
#include "program/viewer/window/gui_internal.h"

#include <assert.h>
#include <cmath>

static ImU32 color_of(uint32_t c)
{
    return IM_COL32(c >> 24, c >> 16 & 255, c >> 8 & 255, c & 255);
}

void gui_graph(const float* values, int count, int newest, float maximum, float mark, float height,
               const char* tooltip)
{
    ImVec2 start = ImGui::GetCursorScreenPos();
    float width = ImGui::GetContentRegionAvail().x;
    assert(newest >= 0 && newest < count && maximum > 0.0f && "values are a ring");
    ImGui::Dummy(ImVec2(width, height));
    gui_tooltip(tooltip);
    ImDrawList* list = ImGui::GetWindowDrawList();
    ImVec2 end = ImVec2(start.x + width, start.y + height);
    list->AddRectFilled(start, end, ImGui::GetColorU32(ImGuiCol_ChildBg), 4.0f * gui_scale);
    float step = width / float(count);
    for (int i = 0; i < count; ++i) {
        float value = values[(newest + 1 + i) % count];
        float part = value < maximum ? value / maximum : 1.0f;
        if (part > 0.0f) {
            bool over = mark > 0.0f && value > 1.1f * mark;
            list->AddRectFilled(ImVec2(start.x + float(i) * step, end.y - part * height),
                                ImVec2(start.x + float(i + 1) * step - 1.0f, end.y),
                                over ? IM_COL32(220, 150, 70, 255)
                                     : ImGui::GetColorU32(gui_mixed(gui_accent, 0.85f)));
        }
    }
    if (mark > 0.0f && mark < maximum) {
        float y = end.y - mark / maximum * height;
        list->AddLine(ImVec2(start.x, y), ImVec2(end.x, y), IM_COL32(255, 255, 255, 110));
    }
}

void gui_picture(void* texture, float x0, float y0, float x1, float y1)
{
    ImGui::GetBackgroundDrawList()->AddImage(texture, ImVec2(x0, y0), ImVec2(x1, y1));
}

void gui_clip(float x0, float y0, float x1, float y1)
{
    ImGui::GetBackgroundDrawList()->PushClipRect(ImVec2(x0, y0), ImVec2(x1, y1));
}

void gui_unclip(void)
{
    ImGui::GetBackgroundDrawList()->PopClipRect();
}

void gui_line(float x0, float y0, float x1, float y1, uint32_t color, float width)
{
    ImGui::GetBackgroundDrawList()->AddLine(ImVec2(x0, y0), ImVec2(x1, y1), color_of(color),
                                            width * gui_scale);
}

void gui_disc(float x, float y, float radius, uint32_t fill, uint32_t rim)
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddCircleFilled(ImVec2(x, y), radius * gui_scale, color_of(fill));
    list->AddCircle(ImVec2(x, y), radius * gui_scale, color_of(rim), 0, 1.5f * gui_scale);
}

void gui_polygon(const float* corners, int count, uint32_t fill, uint32_t rim)
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i < count; ++i) {
            list->PathLineTo(ImVec2(corners[2 * i], corners[2 * i + 1]));
        }
        if (pass == 0) {
            list->PathFillConvex(color_of(fill));
        } else {
            list->PathStroke(color_of(rim), ImDrawFlags_Closed, 1.0f * gui_scale);
        }
    }
}

void gui_letters(float x, float y, float size, const char* text, uint32_t color)
{
    gui_need_letters(text);
    float height = size * ImGui::GetFontSize();
    ImVec2 extent = ImGui::GetFont()->CalcTextSizeA(height, 1e6f, 0.0f, text);
    ImVec2 start = ImVec2(std::floor(x - 0.5f * extent.x + 0.5f), std::floor(y - 0.5f * extent.y));
    ImGui::GetBackgroundDrawList()->AddText(ImGui::GetFont(), height, start, color_of(color), text);
}

void gui_box(float x0, float y0, float x1, float y1, uint32_t fill, uint32_t rim)
{
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(x0, y0), ImVec2(x1, y1), color_of(fill), 6.0f * gui_scale);
    list->AddRect(ImVec2(x0, y0), ImVec2(x1, y1), color_of(rim), 6.0f * gui_scale);
}

void gui_fill(float x0, float y0, float x1, float y1, uint32_t fill)
{
    ImGui::GetBackgroundDrawList()->AddRectFilled(ImVec2(x0, y0), ImVec2(x1, y1), color_of(fill));
}

void gui_resize_cursor(void)
{
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
}

static float show_plate(float x, float y, float share, float widest, const char* text,
                        uint32_t color)
{
    gui_need_letters(text);
    float line = ImGui::GetTextLineHeight();
    ImVec2 size = ImGui::CalcTextSize(text, nullptr, false, widest);
    // further lines go up, away from the annotated point
    ImVec2 start = ImVec2(std::floor(x - share * size.x), std::floor(y + 0.5f * line - size.y));
    ImVec2 pad = ImVec2(6.0f * gui_scale, 3.0f * gui_scale);
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(start.x - pad.x, start.y - pad.y),
                        ImVec2(start.x + size.x + pad.x, start.y + size.y + pad.y),
                        IM_COL32(24, 26, 29, 225), 4.0f * gui_scale);
    list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), start, color_of(color), text, nullptr,
                  widest);
    return size.y - line;
}

void gui_plate(float x, float y, const char* text, uint32_t color)
{
    show_plate(x, y, 0.5f, 300.0f * gui_scale, text, color);
}

float gui_plate_at(float x, float y, float room, const char* text, uint32_t color)
{
    return show_plate(x, y, 0.0f, room > 1.0f ? room : 1.0f, text, color);
}
