//! The frame of a page: head, style sheet, the little script, and escaping.

/// Text made safe for HTML.
pub fn escape(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(c),
        }
        out
    })
}

/// A whole page.
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n<main>\n{body}</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n",
        escape(title)
    )
}

/// Tabs that work without a script: one radio button each. `name` is unique in the page.
pub fn tabs(name: &str, panes: &[(String, String)]) -> String {
    if let [(_, only)] = panes {
        return only.clone();
    }
    let mut out = String::from("<div class=\"tabs\">\n");
    for (k, (label, _)) in panes.iter().enumerate() {
        let checked = if k == 0 { " checked=\"checked\"" } else { "" };
        out += &format!(
            "<input type=\"radio\" name=\"{name}\" id=\"{name}-{k}\"{checked}/><label for=\"{name}-{k}\">{}</label>\n",
            escape(label)
        );
    }
    for (_, pane) in panes {
        out += &format!("<div class=\"pane\">\n{pane}</div>\n");
    }
    out + "</div>\n"
}

/// Background of a heat map's cell: the more noise floors, the stronger; none up to 1.
pub fn heat(multiples: f64) -> String {
    // Logarithmic from 1 (nothing) to 30 (full).
    let share = (multiples.max(1.0).ln() / 30f64.ln()).min(1.0);
    format!("background:rgb(213 94 0/{:.2})", 0.85 * share)
}

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#222;--soft:#666;--line:#d5d5d5;--paper:#fff;--card:#f6f6f4;
 --good:#00835f;--fair:#b07400;--bad:#c43c00}
@media(prefers-color-scheme:dark){:root{--ink:#e6e6e6;--soft:#a0a0a0;--line:#444;--paper:#1b1c1e;--card:#25272a;
 --good:#2fbf94;--fair:#e0a63a;--bad:#ff8650}
 svg [fill='#222222']{fill:#d8d8d8} svg [stroke='#888888']{stroke:#777} svg [stroke='#E2E2E2']{stroke:#34363a}
 svg [stroke='#4A4A4A']{stroke:#c9c9c9} svg [fill='#4A4A4A']{fill:#c9c9c9} svg [stroke='#0072B2']{stroke:#56b4e9}
 svg [fill='#0072B2']{fill:#56b4e9} svg [stroke='#D55E00']{stroke:#ff8c42} svg [fill='#D55E00']{fill:#ff8c42}
 .swatch.measured{background:#c9c9c9}
 .swatch[style*='213 94 0)'],.swatch[style*='#d55e00']{background:#ff8c42!important}
 .swatch[style*='0 114 178)'],.swatch[style*='#0072b2']{background:#56b4e9!important}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,sans-serif}
main{max-width:1240px;margin:0 auto;padding:20px 24px 60px}
h1{font-size:1.05rem;font-weight:600;color:var(--soft);margin:0 0 10px}
h2{font-size:1.15rem;margin:34px 0 6px}
h3{font-size:.95rem;margin:14px 0 4px}
p{margin:6px 0;max-width:90ch}
.verdict{font-size:1.3rem;line-height:1.4;font-weight:600;border-left:6px solid var(--soft);padding:4px 0 4px 16px;
 margin:0 0 14px;max-width:none}
.good{border-color:var(--good)}.fair{border-color:var(--fair)}.bad{border-color:var(--bad)}
.facts{display:flex;flex-wrap:wrap;gap:6px 26px;color:var(--soft);margin-bottom:6px}
.facts b{color:var(--ink);font-weight:600}
.soft{color:var(--soft)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:3px 10px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{font-weight:600;color:var(--soft);font-size:.85rem}
th:first-child,td.left,th.left{text-align:left}
td small{color:var(--soft);margin-left:6px}
td[style] small{color:inherit;opacity:.75}
.fails{font-weight:700}
.heat td{text-align:center;min-width:64px;border:1px solid var(--paper)}
.heat th{border:0;text-align:center;font-weight:500}
.heat th.level{text-align:right}
.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(360px,1fr));gap:12px 18px}
.grid.wide{grid-template-columns:1fr}
.flow{display:flex;flex-wrap:wrap;gap:18px 34px;align-items:flex-start}
figure{margin:0;position:relative;min-width:0}
figcaption{font-size:.85rem;font-weight:600;display:flex;justify-content:space-between;gap:8px}
figcaption span{font-weight:400;color:var(--soft)}
svg{width:100%;height:auto;display:block}
.cursor{position:absolute;top:22px;bottom:28px;width:1px;background:var(--soft);display:none;pointer-events:none}
.legend{display:flex;flex-wrap:wrap;gap:4px 18px;font-size:.85rem;margin:8px 0}
.swatch{display:inline-block;width:22px;height:10px;margin-right:6px;vertical-align:middle;border-radius:2px}
.swatch.line{height:3px}
.swatch.measured{background:#4a4a4a}
pre.next{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:8px 12px;margin:8px 0;
 white-space:pre-wrap;overflow-wrap:anywhere}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(430px,1fr));gap:14px;margin-top:8px}
.card{background:var(--card);border:1px solid var(--line);border-top:4px solid var(--soft);border-radius:6px;
 padding:10px 14px;overflow-x:auto}
.card.named{border-top-color:var(--bad)}
.card h3{margin:0 0 4px;font-size:1rem}
.card th,.card td{white-space:normal;padding:3px 6px}
.card td.text{text-align:left;min-width:12ch}
.card td.left{overflow-wrap:anywhere;min-width:8ch}
details{margin:18px 0}
summary{cursor:pointer;font-weight:600}
.tabs>input{position:absolute;opacity:0}
.tabs>label{display:inline-block;padding:6px 14px;border:1px solid var(--line);border-bottom:2px solid var(--line);
 border-radius:6px 6px 0 0;cursor:pointer;margin-right:4px;color:var(--soft)}
.tabs>input:checked+label{color:var(--ink);font-weight:600;border-bottom-color:var(--ink);background:var(--card)}
.tabs>input:focus-visible+label{outline:2px solid var(--fair)}
.tabs>.pane{display:none;padding-top:10px}
.tabs>input:nth-of-type(1):checked~.pane:nth-of-type(1),.tabs>input:nth-of-type(2):checked~.pane:nth-of-type(2),
.tabs>input:nth-of-type(3):checked~.pane:nth-of-type(3),.tabs>input:nth-of-type(4):checked~.pane:nth-of-type(4),
.tabs>input:nth-of-type(5):checked~.pane:nth-of-type(5),.tabs>input:nth-of-type(6):checked~.pane:nth-of-type(6)
{display:block}
@media(max-width:520px){.cards{grid-template-columns:1fr}main{padding:14px 12px 40px}.grid{grid-template-columns:1fr}.verdict{font-size:1.1rem}}
@media print{.tabs>.pane{display:block}main{max-width:none}}
";

/// A time cursor that runs through all plots of a group at once.
const SCRIPT: &str = "
document.querySelectorAll('.grid').forEach(g=>{const fs=[...g.querySelectorAll('figure[data-from]')];
fs.forEach(f=>{const c=document.createElement('div');c.className='cursor';f.append(c)});
g.addEventListener('mousemove',e=>{const f=e.target.closest('figure[data-from]');if(!f)return;
const b=f.querySelector('svg').getBoundingClientRect(),d=f.dataset,l=+d.left,r=+d.right;
const s=((e.clientX-b.left)/b.width-l)/(r-l);if(s<0||s>1)return;
const t=+d.from+s*(d.to-d.from);fs.forEach(o=>{const c=o.querySelector('.cursor');c.style.display='block';
c.style.left=100*(l+s*(r-l))+'%';o.querySelector('figcaption span').textContent='t = '+t.toFixed(3)+' s'})});
g.addEventListener('mouseleave',()=>fs.forEach(o=>{o.querySelector('.cursor').style.display='none';
o.querySelector('figcaption span').textContent=o.dataset.unit}))});
";
