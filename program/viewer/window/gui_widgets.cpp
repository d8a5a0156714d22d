// SPDX-License-Identifier: MIT
// Widgets of panels: texts, buttons, fields, rows.
#include "program/viewer/window/gui.h"
#include "program/viewer/window/gui_internal.h"

#include <cmath>
#include <cstring>
#include <imgui_internal.h>

void gui_text(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    gui_need_letters_of(format, list);
    ImGui::TextV(format, list);
    va_end(list);
}

void gui_dim_text(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    gui_need_letters_of(format, list);
    ImGui::TextDisabledV(format, list);
    va_end(list);
}

void gui_dim_paragraph(const char* format, ...)
{
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    va_list list;
    va_start(list, format);
    gui_need_letters_of(format, list);
    ImGui::TextWrappedV(format, list);
    va_end(list);
    ImGui::PopStyleColor();
}

void gui_paragraph(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    gui_need_letters_of(format, list);
    ImGui::TextWrappedV(format, list);
    va_end(list);
}

void gui_value(const char* name, const char* format, ...)
{
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(0.42f * ImGui::GetWindowWidth());
    ImGui::PushTextWrapPos(0.0f);
    va_list list;
    va_start(list, format);
    gui_need_letters_of(format, list);
    ImGui::TextV(format, list);
    va_end(list);
    ImGui::PopTextWrapPos();
}

static float to_srgb(float linear)
{
    float x = linear > 0.0f ? linear < 1.0f ? linear : 1.0f : 0.0f;
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

void gui_square(const float color[4])
{
    ImVec2 start = ImGui::GetCursorScreenPos();
    float side = ImGui::GetTextLineHeight() - 3.0f * gui_scale;
    ImVec4 shown = {to_srgb(color[0]), to_srgb(color[1]), to_srgb(color[2]), 1.0f};
    ImVec2 from = ImVec2(start.x, start.y + 1.5f * gui_scale);
    ImVec2 to = ImVec2(from.x + side, from.y + side);
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->AddRectFilled(from, to, ImGui::GetColorU32(shown), 3.0f * gui_scale);
    list->AddRect(from, to, ImGui::GetColorU32(ImGuiCol_TextDisabled), 3.0f * gui_scale);
    ImGui::Dummy(ImVec2(side, side));
    ImGui::SameLine();
}

void gui_swatch(const char* name, const float color[4], const char* format, ...)
{
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(0.42f * ImGui::GetWindowWidth());
    gui_square(color);
    ImGui::PushTextWrapPos(0.0f);
    va_list arguments;
    va_start(arguments, format);
    gui_need_letters_of(format, arguments);
    ImGui::TextV(format, arguments);
    va_end(arguments);
    ImGui::PopTextWrapPos();
}

void gui_tooltip(const char* text)
{
    if (text != nullptr && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) &&
        (ImGui::GetCurrentContext()->HoveredId == 0 ||
         ImGui::GetCurrentContext()->HoveredIdTimer >= gui_tooltip_after) &&
        !ImGui::IsAnyMouseDown()) {
        ImGui::BeginTooltip();
        ImGui::PushTextWrapPos(320.0f * gui_scale);
        ImGui::TextUnformatted(text);
        ImGui::PopTextWrapPos();
        ImGui::EndTooltip();
    }
}

bool gui_button(const char* label, const char* tooltip)
{
    bool pressed = ImGui::Button(label);
    gui_tooltip(tooltip);
    return pressed;
}

bool gui_wide_button(const char* label, int share, const char* tooltip)
{
    const ImGuiStyle& style = ImGui::GetStyle();
    float whole = ImGui::GetWindowContentRegionMax().x - ImGui::GetWindowContentRegionMin().x;
    float width = (whole - float(share - 1) * style.ItemSpacing.x) / float(share);
    bool pressed = ImGui::Button(label, ImVec2(width, 0.0f));
    gui_tooltip(tooltip);
    return pressed;
}

bool gui_toggle(const char* label, bool on, const char* tooltip)
{
    if (on) {
        ImGui::PushStyleColor(ImGuiCol_Button, gui_mixed(gui_accent, 0.55f));
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, gui_mixed(gui_accent, 0.7f));
    }
    bool pressed = gui_button(label, tooltip);
    if (on) {
        ImGui::PopStyleColor(2);
    }
    return pressed;
}

bool gui_name_toggle(const char* name, bool on, float beside, const char* tooltip)
{
    gui_need_letters(name);
    const ImGuiStyle& style = ImGui::GetStyle();
    ImVec2 size = ImGui::CalcTextSize(name);
    float wanted = size.x + 2.0f * style.FramePadding.x;
    float room = ImGui::GetContentRegionAvail().x - beside;
    float minimum = ImGui::GetFrameHeight();
    bool fits = wanted <= room;
    float width = fits ? wanted : room > minimum ? room : minimum;
    ImVec2 start = ImGui::GetCursorScreenPos();
    if (on) {
        ImGui::PushStyleColor(ImGuiCol_Button, gui_mixed(gui_accent, 0.55f));
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, gui_mixed(gui_accent, 0.7f));
    }
    bool pressed = ImGui::Button("##name", ImVec2(width, 0.0f));
    if (on) {
        ImGui::PopStyleColor(2);
    }
    gui_tooltip(fits ? tooltip : name);
    ImVec2 text = ImVec2(start.x + style.FramePadding.x, start.y + style.FramePadding.y);
    ImVec2 end = ImVec2(start.x + width - style.FramePadding.x, text.y + size.y);
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->PushClipRect(text, end, true);
    list->AddText(text, ImGui::GetColorU32(ImGuiCol_Text), name);
    list->PopClipRect();
    return pressed;
}

bool gui_check(const char* label, bool* value, const char* tooltip)
{
    bool changed = ImGui::Checkbox(label, value);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_slider(const char* label, float* value, float minimum, float maximum, const char* format,
                const char* tooltip)
{
    bool changed =
        ImGui::SliderFloat(label, value, minimum, maximum, format, ImGuiSliderFlags_AlwaysClamp);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_log_slider(const char* label, float* value, float minimum, float maximum,
                    const char* format, const char* tooltip)
{
    bool changed = ImGui::SliderFloat(label, value, minimum, maximum, format,
                                      ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_log_count(const char* label, uint64_t* value, uint64_t minimum, uint64_t maximum,
                   const char* tooltip)
{
    ImU64 number = *value, from = minimum, to = maximum;
    bool changed = ImGui::SliderScalar(label, ImGuiDataType_U64, &number, &from, &to, "%llu",
                                       ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
    *value = number;
    gui_tooltip(tooltip);
    return changed;
}

bool gui_count(const char* label, uint64_t* value, uint64_t minimum, uint64_t maximum,
               const char* tooltip)
{
    ImU64 number = *value, step = 1, fast_step = 100;
    bool changed = ImGui::InputScalar(label, ImGuiDataType_U64, &number, &step, &fast_step, "%llu");
    *value = number < minimum ? minimum : number > maximum ? maximum : number;
    gui_tooltip(tooltip);
    return changed;
}

void gui_last_place(float place[4])
{
    ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
    float end = from.x + ImGui::CalcItemWidth();
    bool visible = ImGui::IsItemVisible();
    place[0] = visible ? from.x : 0.0f;
    place[1] = visible ? from.y : 0.0f;
    place[2] = visible ? (end < to.x ? end : to.x) : 0.0f;
    place[3] = visible ? to.y : 0.0f;
}

bool gui_number(const char* label, double* value, double step, const char* format,
                const char* tooltip)
{
    bool changed = ImGui::DragScalar(label, ImGuiDataType_Double, value, float(step), nullptr,
                                     nullptr, format);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_whole_number(const char* label, int* value, int minimum, int maximum, const char* tooltip)
{
    bool changed = ImGui::InputInt(label, value);
    *value = *value < minimum ? minimum : *value > maximum ? maximum : *value;
    gui_tooltip(tooltip);
    return changed;
}

bool gui_choice(const char* label, int* value, const char* const* words, int count,
                const char* tooltip)
{
    bool changed = ImGui::Combo(label, value, words, count);
    gui_tooltip(tooltip);
    return changed;
}

bool gui_color(const char* label, float color[3], const char* tooltip)
{
    bool changed = ImGui::ColorEdit3(label, color, ImGuiColorEditFlags_NoInputs);
    gui_tooltip(tooltip);
    return changed;
}

namespace
{
struct completion {
    gui_completer complete;
    void* user;
    size_t size;
};
} // namespace

static int on_completion(ImGuiInputTextCallbackData* data)
{
    const completion* c = static_cast<const completion*>(data->UserData);
    char* text = static_cast<char*>(ImGui::MemAlloc(c->size));
    if (c->complete(data->Buf, text, c->size, c->user)) {
        data->DeleteChars(0, data->BufTextLen);
        data->InsertChars(0, text);
    }
    ImGui::MemFree(text);
    return 0;
}

bool gui_input_completed(const char* label, const char* hint, char* text, size_t size,
                         gui_completer complete, void* user, bool* entered)
{
    gui_need_letters(text);
    char* before = static_cast<char*>(ImGui::MemAlloc(size));
    std::memcpy(before, text, size);
    completion c = {complete, user, size};
    ImGuiInputTextFlags flags = ImGuiInputTextFlags_EnterReturnsTrue;
    flags |= complete != nullptr ? ImGuiInputTextFlags_CallbackCompletion : 0;
    bool done = ImGui::InputTextWithHint(label, hint, text, size, flags,
                                         complete != nullptr ? on_completion : nullptr, &c);
    bool changed = std::strncmp(before, text, size) != 0;
    ImGui::MemFree(before);
    if (entered != nullptr) {
        *entered = done;
    }
    return changed;
}

bool gui_input(const char* label, const char* hint, char* text, size_t size, bool* entered)
{
    return gui_input_completed(label, hint, text, size, nullptr, nullptr, entered);
}

void gui_focus_next(void)
{
    ImGui::SetKeyboardFocusHere();
}

static float row_height()
{
    return ImGui::GetFrameHeight() - 4.0f * gui_scale;
}

// The part of a text that fits; for a path, its end.
static void show_end(ImDrawList* list, ImVec2 at, float room, ImU32 color, const char* text)
{
    if (ImGui::CalcTextSize(text).x > room) {
        float dots = ImGui::CalcTextSize("...").x;
        while (*text != 0 && dots + ImGui::CalcTextSize(text).x > room) {
            do {
                text += 1;
            } while ((*text & 0xC0) == 0x80); // within a character
        }
        list->AddText(at, color, "...");
        at.x += dots;
    }
    list->AddText(at, color, text);
}

int gui_list_row(const char* label, const char* detail, bool selected)
{
    gui_need_letters(label);
    gui_need_letters(detail);
    ImVec2 start = ImGui::GetCursorScreenPos();
    float width = ImGui::GetContentRegionAvail().x, line = row_height();
    bool pressed = ImGui::InvisibleButton("row", ImVec2(width > 1.0f ? width : 1.0f, line));
    bool hovered = ImGui::IsItemHovered();
    ImDrawList* list = ImGui::GetWindowDrawList();
    ImVec2 end = ImVec2(start.x + width, start.y + line);
    if (selected || hovered) {
        list->AddRectFilled(start, end,
                            ImGui::GetColorU32(selected ? ImGuiCol_Header : ImGuiCol_HeaderHovered),
                            3.0f * gui_scale);
    }
    float y = start.y + 0.5f * (line - ImGui::GetTextLineHeight()), pad = 6.0f * gui_scale;
    float name_end = start.x + pad + ImGui::CalcTextSize(label).x + 2.0f * pad;
    float room = end.x - pad - name_end, wanted = ImGui::CalcTextSize(detail).x;
    list->PushClipRect(start, end, true);
    list->AddText(ImVec2(start.x + pad, y), ImGui::GetColorU32(ImGuiCol_Text), label);
    if (room > 0.0f) {
        float used = wanted < room ? wanted : room;
        show_end(list, ImVec2(end.x - pad - used, y), room,
                 ImGui::GetColorU32(ImGuiCol_TextDisabled), detail);
    }
    list->PopClipRect();
    if (hovered && wanted > room) {
        ImGui::SetTooltip("%s\n%s", label, detail);
    }
    bool twice = hovered && ImGui::IsMouseDoubleClicked(0);
    return (pressed ? GUI_ROW_CLICKED : 0) | (twice ? GUI_ROW_DOUBLE : 0);
}

int gui_tree_row(const gui_row* row)
{
    int result = 0;
    gui_need_letters(row->label);
    const char* detail = row->detail != nullptr ? row->detail : "";
    gui_need_letters(detail);
    float line = ImGui::GetFrameHeight() - 4.0f * gui_scale;
    ImVec2 start = ImGui::GetCursorScreenPos();
    float width = ImGui::GetContentRegionAvail().x;
    bool pressed = ImGui::InvisibleButton("row", ImVec2(width > 1.0f ? width : 1.0f, line));
    bool hovered = ImGui::IsItemHovered();
    ImDrawList* list = ImGui::GetWindowDrawList();
    ImVec2 end = ImVec2(start.x + width, start.y + line);
    if (row->selected || hovered) {
        list->AddRectFilled(
            start, end,
            ImGui::GetColorU32(row->selected ? ImGuiCol_Header : ImGuiCol_HeaderHovered),
            3.0f * gui_scale);
    }
    float indent = (4.0f + 13.0f * float(row->depth < 12 ? row->depth : 12)) * gui_scale;
    float fold_end = start.x + indent + 14.0f * gui_scale, eye_begin = end.x - 22.0f * gui_scale;
    float middle = start.y + 0.5f * line;
    ImU32 faint = ImGui::GetColorU32(ImGuiCol_TextDisabled);
    if (row->has_children) {
        float x = start.x + indent + 5.0f * gui_scale, s = 3.5f * gui_scale;
        if (row->open) {
            list->AddTriangleFilled(ImVec2(x - s, middle - 0.6f * s),
                                    ImVec2(x + s, middle - 0.6f * s), ImVec2(x, middle + s), faint);
        } else {
            list->AddTriangleFilled(ImVec2(x - 0.6f * s, middle - s), ImVec2(x + s, middle),
                                    ImVec2(x - 0.6f * s, middle + s), faint);
        }
    }
    list->PushClipRect(start, ImVec2(eye_begin, end.y), true);
    list->AddText(
        ImVec2(fold_end, middle - 0.5f * ImGui::GetTextLineHeight()),
        ImGui::GetColorU32(row->faint || !row->shown ? ImGuiCol_TextDisabled : ImGuiCol_Text),
        row->label);
    float label_end = fold_end + ImGui::CalcTextSize(row->label).x;
    if (detail[0] != 0) {
        label_end += 8.0f * gui_scale;
        show_end(list, ImVec2(label_end, middle - 0.5f * ImGui::GetTextLineHeight()),
                 eye_begin - 4.0f * gui_scale - label_end, faint, detail);
        label_end += ImGui::CalcTextSize(detail).x;
    }
    list->PopClipRect();
    if (hovered || !row->shown) { // the eye
        float x = end.x - 11.0f * gui_scale, r = 4.0f * gui_scale;
        if (row->shown) {
            list->AddCircleFilled(ImVec2(x, middle), r, faint);
        } else {
            list->AddCircle(ImVec2(x, middle), r, faint, 0, 1.5f * gui_scale);
        }
    }
    float at = ImGui::GetIO().MousePos.x;
    if (hovered && at > eye_begin) {
        ImGui::SetTooltip(row->shown ? "Hide" : "Show");
    } else if (hovered && label_end > eye_begin) {
        ImGui::SetTooltip(detail[0] != 0 ? "%s\n%s" : "%s", row->label, detail);
    }
    if (hovered && ImGui::IsMouseDoubleClicked(0) && at >= fold_end && at <= eye_begin) {
        result |= GUI_ROW_DOUBLE;
    }
    if (pressed) {
        result |= at > eye_begin                       ? GUI_ROW_SWITCHED
                  : row->has_children && at < fold_end ? GUI_ROW_OPENED
                                                       : GUI_ROW_CLICKED;
    }
    return result;
}

void gui_rows_begin(int count, int* first, int* last)
{
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(0.0f, 0.0f));
    ImGui::CalcListClipping(count, row_height(), first, last);
    ImGui::Dummy(ImVec2(1.0f, float(*first) * row_height()));
}

void gui_rows_end(int count, int last)
{
    ImGui::Dummy(ImVec2(1.0f, float(count - last) * row_height()));
    ImGui::PopStyleVar();
}

void gui_list_begin(const char* name, float height)
{
    ImGui::PushStyleVar(ImGuiStyleVar_ChildRounding, 4.0f * gui_scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(4.0f * gui_scale, 4.0f * gui_scale));
    ImGui::BeginChild(name, ImVec2(0.0f, height), false,
                      ImGuiWindowFlags_AlwaysUseWindowPadding | ImGuiWindowFlags_NoNav);
    ImGui::PopStyleVar(2);
}

void gui_list_end(void)
{
    ImGui::EndChild();
}

void gui_scroll_to_row(int row)
{
    float middle = (float(row) + 0.5f) * row_height() - 0.4f * ImGui::GetWindowHeight();
    ImGui::SetScrollY(middle > 0.0f ? middle : 0.0f);
}

void gui_progress(float fraction, const char* text)
{
    ImGui::ProgressBar(fraction, ImVec2(-1.0f, 0.0f), text);
}
