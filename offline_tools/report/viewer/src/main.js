import { show_flight_page } from './flight_page.js';
import { escape_html } from './markup.js';
import { show_map_page } from './map_page.js';
import { show_plan_page } from './plan_page.js';
import { start_theme } from './theme.js';

const kPages = { flight: show_flight_page, plan: show_plan_page, map: show_map_page };

function show_page() {
  const host = document.getElementById('page');
  const report = JSON.parse(document.getElementById('report').textContent);
  start_theme();
  try {
    kPages[report.kind](host, report);
  } catch (error) {
    host.insertAdjacentHTML('afterbegin', `<p class="error">This report could not be drawn: ${escape_html(error.message)}</p>`);
    throw error;
  }
}

show_page();
