#include "study/html.h"

#include <array>
#include <cstdint>
#include <cstdio>

namespace primo::study::html {

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string number(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

std::string image_url(std::string_view bytes, std::string_view type) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out = "data:image/";
  out.append(type).append(";base64,");
  out.reserve(out.size() + bytes.size() * 4 / 3 + 4);
  const auto byte = [&](std::size_t i) {
    return i < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) : 0u;
  };
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (unsigned k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string figure(const std::string& url, const std::string& caption) {
  return "<figure><img alt=\"" + escape(caption) + "\" src=\"" + url + "\"><figcaption>" + escape(caption) +
         "</figcaption></figure>";
}

std::string section(const std::string& title, const std::string& content) {
  return "<section><h2>" + title + "</h2>\n" + content + "</section>\n";
}

std::string rate_cell(const Rate& rate) {
  if (rate.trials == 0) return "–";
  return "<b>" + number("%.0f", 100 * rate.value()) + " %</b><small>" + std::to_string(rate.successes) + " of " +
         std::to_string(rate.trials) + ", 95 %: " + number("%.0f", 100 * rate.lower()) + "–" +
         number("%.0f", 100 * rate.upper()) + " %</small>";
}

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<div class=\"scroll\"><table><thead><tr>";
  for (const auto& cell : head) out.append("<th>").append(cell).append("</th>");
  out += "</tr></thead><tbody>";
  for (const auto& row : rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      out.append(i == 0 ? "<th>" : "<td>").append(row[i]).append(i == 0 ? "</th>" : "</td>");
    }
    out += "</tr>";
  }
  return out + "</tbody></table></div>\n";
}

const char* const kStyle = R"css(
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#5b6570;--line:#dfe3e8;--ground:#f6f7f9;--card:#fff;--before:#3b6fb6;--after:#c0392b;
--a:#c0392b;--b:#3b6fb6;--c:#2f8f5b;--d:#8e5bb5}
@media(prefers-color-scheme:dark){:root{--ink:#e7eaee;--soft:#9aa5b1;--line:#323a43;--ground:#14181c;--card:#1d2328;--before:#7ba7e0;
--after:#ef8577;--a:#ef8577;--b:#7ba7e0;--c:#6fcf97;--d:#c39be0}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:1080px;margin:0 auto;padding:28px 18px 60px}
h1{font-size:1.75rem;line-height:1.2;margin:0 0 4px}
h2{font-size:1.15rem;margin:0 0 12px}
h3{font-size:1rem;margin:16px 0 8px}
p{margin:0 0 12px}
.sub{color:var(--soft);margin-bottom:22px}
section{background:var(--card);border:1px solid var(--line);border-radius:12px;padding:20px 22px;margin:0 0 18px}
.tiles,.pair{display:grid;gap:14px;grid-template-columns:repeat(auto-fit,minmax(230px,1fr))}
.pair{grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr))}
.tiles{margin-bottom:18px}
.tile{background:var(--card);border:1px solid var(--line);border-radius:12px;padding:16px 18px}
.tile .what{color:var(--soft);font-size:.88rem}
.tile .big{font-size:1.7rem;font-weight:650;line-height:1.25}
.tile .big i{font-style:normal;color:var(--before)}.tile .big b{color:var(--after)}
.tile small{color:var(--soft);display:block}
.rule{border-left:4px solid var(--line);padding:2px 0 2px 14px;overflow-x:auto}
.rule.before{border-color:var(--before)}.rule.after{border-color:var(--after)}
.rule h3{font-size:.95rem;margin:0 0 6px;color:var(--soft);font-weight:600}
.rule .head{font-family:Georgia,"DejaVu Serif",serif;font-size:1.06rem}
.outcomes{display:grid;grid-template-columns:auto auto 1fr;column-gap:14px;row-gap:2px;margin:8px 0 8px 8px;padding-left:16px;
border-left:2px solid var(--ink);border-radius:12px 0 0 12px;font-family:Georgia,"DejaVu Serif",serif;align-items:baseline}
.outcomes .p{font-weight:650}.outcomes small{white-space:nowrap;color:var(--soft);font:.82rem system-ui,"DejaVu Sans",sans-serif}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.93rem}
th,td{text-align:left;padding:7px 14px 7px 0;border-bottom:1px solid var(--line);vertical-align:top}
thead th{color:var(--soft);font-weight:600;font-size:.85rem}tbody th{font-weight:500}
td small{display:block;color:var(--soft);font-size:.8rem}
td{font-variant-numeric:tabular-nums}
figure{margin:0}figure img{width:100%;height:auto;border-radius:8px;display:block;background:#ddd}
figcaption{color:var(--soft);font-size:.86rem;margin-top:6px}
h2.part{font-size:1.4rem;margin:34px 0 14px}
nav{margin:0 0 18px;display:flex;gap:16px;flex-wrap:wrap}nav a{color:var(--before)}
.three{display:grid;gap:14px;grid-template-columns:repeat(auto-fit,minmax(min(100%,290px),1fr))}
.bar{background:var(--line);border-radius:4px;height:9px;min-width:120px;overflow:hidden}.bar i{display:block;height:100%}
.note{color:var(--soft);font-size:.9rem}.scroll+.note{margin-top:12px}
details{margin-top:10px}summary{cursor:pointer;font-weight:600}
pre{overflow:auto;max-height:480px;background:var(--ground);border:1px solid var(--line);border-radius:8px;padding:12px;
font:12.5px/1.45 ui-monospace,"DejaVu Sans Mono",monospace}
)css";

}  // namespace primo::study::html
