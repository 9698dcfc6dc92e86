// Numbers as the tables and charts show them.
import { type Num, isFinite } from './data';

const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';

export const raised = (exponent: number): string =>
  (exponent < 0 ? '⁻' : '') + [...String(Math.abs(exponent))].map((digit) => superscripts[Number(digit)]).join('');

// 12.3, 4.6·10⁷, –
export function text(value: Num | undefined, digits = 3): string {
  if (!isFinite(value)) return '–';
  const size = Math.abs(value);
  if (value !== 0 && (size >= 1e5 || size < 1e-3)) {
    const [mantissa, exponent] = value.toExponential(Math.max(0, digits - 2)).split('e');
    return `${mantissa}·10${raised(Number(exponent))}`;
  }
  return size >= 1000 ? new Intl.NumberFormat('en', { maximumFractionDigits: 0 }).format(value) : String(Number(value.toPrecision(digits)));
}

// The mark of a logarithmic axis.
export function power(value: number): string {
  const exponent = Math.log10(value);
  if (Math.abs(exponent - Math.round(exponent)) > 1e-6) return text(value);
  return Math.abs(exponent) < 3 ? String(Number(value.toPrecision(1))) : `10${raised(Math.round(exponent))}`;
}
